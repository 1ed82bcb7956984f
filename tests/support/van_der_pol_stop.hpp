// SPDX-License-Identifier: GPL-3.0-or-later
// x'' - mu (1 - x^2) x' + x = 0 with a rigid stop x <= r. State (x, x'); parameters mu, r, k_r. For 0 < r < 2 the limit cycle
// hits the stop once per cycle; it has one trivial multiplier.
#pragma once

#include "support/rigid_stop.hpp"

#include <cmath>

namespace graze::support {

inline HybridSystem van_der_pol_stop() {
  enum : Eigen::Index { mu, r, k_r };
  using detail::parameter;
  HybridSystem system;
  system.name = "van-der-pol-stop";
  system.states = 2;
  system.parameters = {parameter("mu", 0.5), parameter("r", 1.2), parameter("k_r", 0.9, 0.0, false, 1.0)};
  Mode mode;
  mode.name = "free";
  mode.field = [](double, const Vector& x, const Vector& p, Vector& f) { f << x[1], p[mu] * (1.0 - x[0] * x[0]) * x[1] - x[0]; };
  mode.field_dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J << 0.0, 1.0, -2.0 * p[mu] * x[0] * x[1] - 1.0, p[mu] * (1.0 - x[0] * x[0]);
  };
  mode.field_dp = [](double, const Vector& x, const Vector&, Matrix& J) {
    J.setZero();
    J(1, mu) = (1.0 - x[0] * x[0]) * x[1];
  };
  system.modes = {mode};
  system.events = {detail::rigid_stop("impact", 0, r, k_r, 1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] > p[r]) return std::nullopt;
    return 0;
  };
  return system;
}

}  // namespace graze::support
