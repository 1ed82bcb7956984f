// SPDX-License-Identifier: GPL-3.0-or-later
// x'' = -g above a floor at x = floor. An impact there gives speed -> -k_r speed; finally the ball rests on the floor. State
// (x, x'); parameters g, floor, k_r. Dropped from height H above the floor it comes to rest after sqrt(2 H/g) (1 + k_r)/(1 -
// k_r).
#pragma once

#include "support/rigid_stop.hpp"

#include <cmath>

namespace graze::support {

inline HybridSystem bouncing_ball() {
  enum : Eigen::Index { g, floor, k_r };
  using detail::parameter;
  HybridSystem system;
  system.name = "bouncing-ball";
  system.states = 2;
  system.parameters = {parameter("g", 9.81, 0.0, true), parameter("floor", 0.0), parameter("k_r", 0.8, 0.0, false, 1.0)};
  Mode flying, resting;
  flying.name = "flying";
  flying.field = [](double, const Vector& x, const Vector& p, Vector& f) { f << x[1], -p[g]; };
  flying.field_dx = [](double, const Vector&, const Vector&, Matrix& J) { J << 0.0, 1.0, 0.0, 0.0; };
  flying.field_dp = [](double, const Vector&, const Vector&, Matrix& J) {
    J.setZero();
    J(1, g) = -1.0;
  };
  resting.name = "resting";
  resting.field = [](double, const Vector&, const Vector&, Vector& f) { f.setZero(); };
  resting.field_dx = resting.field_dp = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  system.modes = {flying, resting};
  Event bounce = detail::rigid_stop("bounce", 0, floor, k_r, -1.0);
  Accumulation rest;
  rest.sticking_mode = 1;
  rest.reset.map = [](double, const Vector&, const Vector& p, Vector& out) { out << p[floor], 0.0; };
  rest.reset.dx = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  rest.reset.dp = [](double, const Vector&, const Vector&, Matrix& J) {
    J.setZero();
    J(0, floor) = 1.0;
  };
  bounce.accumulation = rest;
  system.events = {bounce};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] < p[floor]) return std::nullopt;
    return x[0] == p[floor] && x[1] == 0.0 ? 1 : 0;
  };
  return system;
}

}  // namespace graze::support
