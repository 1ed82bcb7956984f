// SPDX-License-Identifier: GPL-3.0-or-later
// Parts of the test systems: dimensionless parameters, and rigid stops with Newton's law. These systems
// (two_mass_oscillator.hpp, two_sided_oscillator.hpp, ...) differ from the one-barrier oscillator, because the library must
// not be limited to two states, one barrier or a forcing. All are dimensionless. All derivatives are written by hand and
// checked in tests/lib/other_systems.cpp.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <cmath>
#include <limits>

namespace graze::support {

namespace detail {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

inline ParameterInfo parameter(std::string name, double value, double lower = -infinity, bool open = false,
                               double upper = infinity) {
  return {std::move(name), value, lower, upper, open, "dimensionless", ""};
}

/// Guard and reset of the rigid stop of x[position] at p[level], approached with sign * speed > 0: speed -> -p[restitution]
/// speed.
inline Event rigid_stop(std::string name, Eigen::Index position, std::size_t level, std::size_t restitution, double sign) {
  const Eigen::Index speed = position + 1, wall = static_cast<Eigen::Index>(level), k_r = static_cast<Eigen::Index>(restitution);
  Event event;
  event.name = std::move(name);
  event.kind = EventKind::impact;
  event.guard = make_level_guard({.coordinate = static_cast<std::size_t>(position), .level = level, .sign = sign});
  event.reset.map = [=](double, const Vector& x, const Vector& p, Vector& out) {
    out = x;
    out[position] = p[wall];
    out[speed] = -p[k_r] * x[speed];
  };
  event.reset.dx = [=](double, const Vector&, const Vector& p, Matrix& J) {
    J.setIdentity();
    J(position, position) = 0.0;
    J(speed, speed) = -p[k_r];
  };
  event.reset.dp = [=](double, const Vector& x, const Vector&, Matrix& J) {
    J.setZero();
    J(position, wall) = 1.0;
    J(speed, k_r) = -x[speed];
  };
  event.log_volume_change = [=](const Vector& p) { return 2.0 * std::log(p[k_r]); };
  return event;
}

}  // namespace detail

}  // namespace graze::support
