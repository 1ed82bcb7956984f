// SPDX-License-Identifier: GPL-3.0-or-later
// x'' + 2 b x' + x + F(x) = xi cos(eta t) between barriers at -r and +r: rigid (x'+ = -k_r x'-) or elastic (F = k_S (|x| - r)
// sign x beyond them). State (x, x'); parameters b, xi, eta, r, then k_r (rigid) or k_S (elastic). Symmetric under (x, t) ->
// (-x, t + T/2): symmetric orbits of period 1 lose their symmetry in pitchforks (BP), never in PD. The guard of the barrier at
// -r is not a level given by a parameter, so that the general flow carries the motion.
#pragma once

#include "support/rigid_stop.hpp"

#include <cmath>

namespace graze::support {

inline HybridSystem two_sided_oscillator(bool rigid) {
  enum : Eigen::Index { b, xi, eta, r, k };
  using detail::parameter;
  HybridSystem system;
  system.name = rigid ? "two-sided-rigid" : "two-sided-elastic";
  system.states = 2;
  system.parameters = {parameter("b", 0.05, 0.0), parameter("xi", 1.0), parameter("eta", 0.9, 0.0, true),
                       parameter("r", 1.0, 0.0, true),
                       rigid ? parameter("k_r", 0.8, 0.0, false, 1.0) : parameter("k_S", 25.0, 0.0, true)};
  system.forcing_frequency = eta;
  // side: -1, 0 (free), +1.
  const auto mode_of = [](std::string name, double side) {
    Mode mode;
    mode.name = std::move(name);
    mode.field = [side](double t, const Vector& x, const Vector& p, Vector& f) {
      f[0] = x[1];
      f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - x[0];
      if (side != 0.0) f[1] -= p[k] * (x[0] - side * p[r]);
    };
    mode.field_dx = [side](double, const Vector&, const Vector& p, Matrix& J) {
      J << 0.0, 1.0, -1.0 - (side != 0.0 ? p[k] : 0.0), -2.0 * p[b];
    };
    mode.field_dp = [side](double t, const Vector& x, const Vector& p, Matrix& J) {
      J.setZero();
      J(1, b) = -2.0 * x[1];
      J(1, xi) = std::cos(p[eta] * t);
      J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
      if (side != 0.0) {
        J(1, r) = side * p[k];
        J(1, k) = -(x[0] - side * p[r]);
      }
    };
    mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) { f << 0.0, -p[xi] * p[eta] * std::sin(p[eta] * t); };
    return mode;
  };
  // Guard h = sign (x - side r).
  const auto guard_of = [](double sign, double side) {
    Guard guard;
    guard.value = [=](double, const Vector& x, const Vector& p) { return sign * (x[0] - side * p[r]); };
    guard.dx = [=](double, const Vector&, const Vector&, Vector& g) { g << sign, 0.0; };
    guard.dp = [=](double, const Vector&, const Vector&, Vector& g) {
      g.setZero();
      g[r] = -sign * side;
    };
    return guard;
  };
  system.modes = {mode_of("free", 0.0)};
  if (rigid) {
    Event upper = detail::rigid_stop("impact-upper", 0, r, k, 1.0), lower = upper;
    lower.name = "impact-lower";
    lower.guard = guard_of(-1.0, -1.0);
    lower.reset.map = [](double, const Vector& x, const Vector& p, Vector& out) { out << -p[r], -p[k] * x[1]; };
    lower.reset.dp = [](double, const Vector& x, const Vector&, Matrix& J) {
      J.setZero();
      J(0, r) = -1.0;
      J(1, k) = -x[1];
    };
    system.events = {upper, lower};
    system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
      if (std::abs(x[0]) > p[r]) return std::nullopt;
      return 0;
    };
    return system;
  }
  system.modes.push_back(mode_of("upper", 1.0));
  system.modes.push_back(mode_of("lower", -1.0));
  const auto event_of = [&](std::string name, std::size_t from, std::size_t to, EventKind kind, double sign, double side) {
    Event event;
    event.name = std::move(name);
    event.from = from;
    event.to = to;
    event.kind = kind;
    event.continuous = true;
    event.guard = guard_of(sign, side);
    return event;
  };
  system.events = {
      event_of("enter-upper", 0, 1, EventKind::enter, 1.0, 1.0), event_of("enter-lower", 0, 2, EventKind::enter, -1.0, -1.0),
      event_of("leave-upper", 1, 0, EventKind::leave, -1.0, 1.0), event_of("leave-lower", 2, 0, EventKind::leave, 1.0, -1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] > p[r] || (x[0] == p[r] && x[1] > 0.0)) return 1;
    if (x[0] < -p[r] || (x[0] == -p[r] && x[1] < 0.0)) return 2;
    return 0;
  };
  return system;
}

}  // namespace graze::support
