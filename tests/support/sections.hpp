// SPDX-License-Identifier: GPL-3.0-or-later
// Smooth autonomous systems with a section: the crossings of the plane state[k] = 0 from below. The plane separates two modes
// of the same field.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <string>
#include <utility>

namespace graze::support {

struct SmoothField {
  std::string name;
  std::size_t states = 0;
  std::vector<ParameterInfo> parameters;
  VectorFunction field;
  MatrixFunction dx, dp;
};

inline HybridSystem with_section(const SmoothField& smooth, std::size_t coordinate) {
  const auto k = static_cast<Eigen::Index>(coordinate);
  HybridSystem system;
  system.name = smooth.name;
  system.states = smooth.states;
  system.parameters = smooth.parameters;
  for (const char* name : {"below", "above"}) {
    Mode mode;
    mode.name = name;
    mode.field = smooth.field;
    mode.field_dx = smooth.dx;
    mode.field_dp = smooth.dp;
    system.modes.push_back(mode);
  }
  for (const std::size_t from : {std::size_t{0}, std::size_t{1}}) {
    const double sign = from == 0 ? 1.0 : -1.0;
    Event event;
    event.name = from == 0 ? "up" : "down";
    event.from = from;
    event.to = 1 - from;
    event.continuous = true;
    event.guard.value = [sign, k](double, const Vector& x, const Vector&) { return sign * x[k]; };
    event.guard.dx = [sign, k](double, const Vector&, const Vector&, Vector& gradient) {
      gradient.setZero();
      gradient[k] = sign;
    };
    system.events.push_back(event);
  }
  system.returns = {0};
  system.initial_mode = [k](double, const Vector& x, const Vector&) -> std::optional<std::size_t> { return x[k] >= 0.0 ? 1 : 0; };
  return system;
}

namespace detail {
inline ParameterInfo with_default(const char* name, double value) {
  ParameterInfo parameter;
  parameter.name = name;
  parameter.default_value = value;
  return parameter;
}
}  // namespace detail

/// x' = v, v' = mu (1 - x^2) v - x, with the section x = 0, x increasing.
inline HybridSystem van_der_pol() {
  SmoothField smooth;
  smooth.name = "van-der-pol";
  smooth.states = 2;
  smooth.parameters = {detail::with_default("mu", 1.0)};
  smooth.field = [](double, const Vector& x, const Vector& p, Vector& f) { f << x[1], p[0] * (1.0 - x[0] * x[0]) * x[1] - x[0]; };
  smooth.dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J << 0.0, 1.0, -2.0 * p[0] * x[0] * x[1] - 1.0, p[0] * (1.0 - x[0] * x[0]);
  };
  smooth.dp = [](double, const Vector& x, const Vector&, Matrix& J) { J << 0.0, (1.0 - x[0] * x[0]) * x[1]; };
  return with_section(smooth, 0);
}

/// x' = -y - z, y' = x + a y, z' = b + z (x - c) (Roessler, Phys. Lett. A 57 (1976) 397), with the section y = 0, y
/// increasing.
inline HybridSystem roessler() {
  SmoothField smooth;
  smooth.name = "roessler";
  smooth.states = 3;
  smooth.parameters = {detail::with_default("a", 0.2), detail::with_default("b", 0.2), detail::with_default("c", 5.7)};
  smooth.field = [](double, const Vector& x, const Vector& p, Vector& f) {
    f << -x[1] - x[2], x[0] + p[0] * x[1], p[1] + x[2] * (x[0] - p[2]);
  };
  smooth.dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J << 0.0, -1.0, -1.0, 1.0, p[0], 0.0, x[2], 0.0, x[0] - p[2];
  };
  smooth.dp = [](double, const Vector& x, const Vector&, Matrix& J) { J << 0.0, 0.0, 0.0, x[1], 0.0, 0.0, 0.0, 1.0, -x[2]; };
  return with_section(smooth, 1);
}

}  // namespace graze::support
