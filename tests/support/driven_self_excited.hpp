// SPDX-License-Identifier: GPL-3.0-or-later
// x'' + 2 b x' + x = xi cos(eta t), x <= r rigid (k_r), driving y'' - (mu - y^2) y' + omega^2 y = epsilon x.
// State (x, x', y, y'); parameters b, xi, eta, r, k_r, mu, omega, epsilon. At epsilon = 0 and y = 0 two multipliers of a
// period-n orbit are exactly exp((mu/2 +- i sqrt(omega^2 - mu^2/4)) n T): Neimark-Sacker at mu = 0. At epsilon != 0 it lies
// near mu = mean of y^2.
#pragma once

#include "support/rigid_stop.hpp"

#include <cmath>

namespace graze::support {

inline HybridSystem driven_self_excited() {
  enum : Eigen::Index { b, xi, eta, r, k_r, mu, omega, epsilon };
  using detail::parameter;
  HybridSystem system;
  system.name = "driven-self-excited";
  system.states = 4;
  system.parameters = {parameter("b", 0.05, 0.0),
                       parameter("xi", 1.0),
                       parameter("eta", 0.8, 0.0, true),
                       parameter("r", 1.0),
                       parameter("k_r", 0.6, 0.0, false, 1.0),
                       parameter("mu", -0.1),
                       parameter("omega", 0.55, 0.0, true),
                       parameter("epsilon", 0.0)};
  system.forcing_frequency = eta;
  Mode mode;
  mode.name = "free";
  mode.field = [](double t, const Vector& x, const Vector& p, Vector& f) {
    f[0] = x[1];
    f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - x[0];
    f[2] = x[3];
    f[3] = (p[mu] - x[2] * x[2]) * x[3] - p[omega] * p[omega] * x[2] + p[epsilon] * x[0];
  };
  mode.field_dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(0, 1) = J(2, 3) = 1.0;
    J(1, 0) = -1.0;
    J(1, 1) = -2.0 * p[b];
    J(3, 0) = p[epsilon];
    J(3, 2) = -2.0 * x[2] * x[3] - p[omega] * p[omega];
    J(3, 3) = p[mu] - x[2] * x[2];
  };
  mode.field_dp = [](double t, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(1, b) = -2.0 * x[1];
    J(1, xi) = std::cos(p[eta] * t);
    J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
    J(3, mu) = x[3];
    J(3, omega) = -2.0 * p[omega] * x[2];
    J(3, epsilon) = x[0];
  };
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f.setZero();
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
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
