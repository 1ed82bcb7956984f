// SPDX-License-Identifier: GPL-3.0-or-later
// A relay with hysteresis and a third-order lag: x1' = a (x2 - x1), x2' = a (x3 - x2), x3' = a (u - x3). In mode "down" u =
// -gain until x1 falls to -w, in mode "up" u = +gain until x1 rises to w. State (x1, x2, x3); parameters a, gain, w. Symmetric
// limit cycle: half a period maps x to -x, so that x(0) = (I + e^{A h})^{-1} (integral of e^{A s} B u ds).
#pragma once

#include "support/rigid_stop.hpp"

#include <cmath>

namespace graze::support {

inline HybridSystem relay_feedback() {
  enum : Eigen::Index { a, gain, w };
  using detail::parameter;
  HybridSystem system;
  system.name = "relay-feedback";
  system.states = 3;
  system.parameters = {parameter("a", 1.0, 0.0, true), parameter("gain", 1.0, 0.0, true), parameter("w", 0.05, 0.0, true)};
  const auto mode_of = [](std::string name, double sign) {
    Mode mode;
    mode.name = std::move(name);
    mode.field = [sign](double, const Vector& x, const Vector& p, Vector& f) {
      f << p[a] * (x[1] - x[0]), p[a] * (x[2] - x[1]), p[a] * (sign * p[gain] - x[2]);
    };
    mode.field_dx = [](double, const Vector&, const Vector& p, Matrix& J) {
      J << -p[a], p[a], 0.0, 0.0, -p[a], p[a], 0.0, 0.0, -p[a];
    };
    mode.field_dp = [sign](double, const Vector& x, const Vector& p, Matrix& J) {
      J.setZero();
      J.col(a) << x[1] - x[0], x[2] - x[1], sign * p[gain] - x[2];
      J(2, gain) = sign * p[a];
    };
    return mode;
  };
  system.modes = {mode_of("up", 1.0), mode_of("down", -1.0)};
  const auto switch_of = [](std::string name, std::size_t from, std::size_t to, double sign) {
    Event event;
    event.name = std::move(name);
    event.from = from;
    event.to = to;
    event.guard.value = [sign](double, const Vector& x, const Vector& p) { return sign * x[0] - p[w]; };
    event.guard.dx = [sign](double, const Vector&, const Vector&, Vector& g) { g << sign, 0.0, 0.0; };
    event.guard.dp = [](double, const Vector&, const Vector&, Vector& g) {
      g.setZero();
      g[w] = -1.0;
    };
    return event;
  };
  system.events = {switch_of("switch-down", 0, 1, 1.0), switch_of("switch-up", 1, 0, -1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    return x[0] < p[w] ? 0 : 1;
  };
  return system;
}

}  // namespace graze::support
