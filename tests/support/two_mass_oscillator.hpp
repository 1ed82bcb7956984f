// SPDX-License-Identifier: GPL-3.0-or-later
// x1'' + 2 b x1' + x1 + kappa (x1 - x2) = xi cos(eta t),  mu x2'' + 2 b x2' + x2 + kappa (x2 - x1) = 0,  x1 <= r1, x2 <= r2.
// State (x1, x1', x2, x2'); parameters b, kappa, mu, xi, eta, r1, r2, k_r. With mu = 1, equal starts and no forcing the masses
// move as one, and have impacts at the same instant if r1 = r2.
#pragma once

#include "support/rigid_stop.hpp"

#include <cmath>

namespace graze::support {

inline HybridSystem two_mass_oscillator() {
  enum : Eigen::Index { b, kappa, mu, xi, eta, r1, r2, k_r };
  using detail::parameter;
  HybridSystem system;
  system.name = "two-mass";
  system.states = 4;
  system.parameters = {parameter("b", 0.05, 0.0), parameter("kappa", 0.5, 0.0),          parameter("mu", 0.8, 0.0, true),
                       parameter("xi", 1.0),      parameter("eta", 0.9, 0.0, true),      parameter("r1", 1.0),
                       parameter("r2", 1.2),      parameter("k_r", 0.8, 0.0, false, 1.0)};
  system.forcing_frequency = eta;
  Mode mode;
  mode.name = "free";
  mode.field = [](double t, const Vector& x, const Vector& p, Vector& f) {
    f[0] = x[1];
    f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - x[0] - p[kappa] * (x[0] - x[2]);
    f[2] = x[3];
    f[3] = (-2.0 * p[b] * x[3] - x[2] - p[kappa] * (x[2] - x[0])) / p[mu];
  };
  mode.field_dx = [](double, const Vector&, const Vector& p, Matrix& J) {
    J << 0.0, 1.0, 0.0, 0.0,                                                    //
        -1.0 - p[kappa], -2.0 * p[b], p[kappa], 0.0,                            //
        0.0, 0.0, 0.0, 1.0,                                                     //
        p[kappa] / p[mu], 0.0, (-1.0 - p[kappa]) / p[mu], -2.0 * p[b] / p[mu];  //
  };
  mode.field_dp = [](double t, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(1, b) = -2.0 * x[1];
    J(3, b) = -2.0 * x[3] / p[mu];
    J(1, kappa) = x[2] - x[0];
    J(3, kappa) = (x[0] - x[2]) / p[mu];
    J(3, mu) = (2.0 * p[b] * x[3] + x[2] + p[kappa] * (x[2] - x[0])) / (p[mu] * p[mu]);
    J(1, xi) = std::cos(p[eta] * t);
    J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
  };
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f.setZero();
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
  };
  system.modes = {mode};
  system.events = {detail::rigid_stop("impact-1", 0, r1, k_r, 1.0), detail::rigid_stop("impact-2", 2, r2, k_r, 1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] > p[r1] || x[2] > p[r2]) return std::nullopt;
    return 0;
  };
  return system;
}

}  // namespace graze::support
