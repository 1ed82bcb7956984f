// SPDX-License-Identifier: GPL-3.0-or-later
// Closed form of the Newton oscillator's orbits with one impact in n forcing periods (beta = 0). With the impact at x = r, speed v
// before it, P = (x_p, x_p') the forced response at that instant and Phi the free flight over n T,
//     (r, v) = P + Phi ((r, -k_r v) - P)   =>   P = (I - Phi)^{-1} [(r, v) - Phi (r, -k_r v)] = P_0 + v P_1,
//     (xi A)^2 = P_x^2 + (P_v / eta)^2,    A = 1 / sqrt((1 - eta^2)^2 + (2 b eta)^2):
// the forcing amplitude as a function of the impact speed, a parabola in xi^2. Its vertex is the fold; v = 0 is the grazing.
#pragma once

#include <Eigen/Dense>

#include <cmath>
#include <numbers>

namespace one_impact {

struct Oscillator {
  double b, eta, r, k_r;
  int n;
};

struct Family {
  double constant, linear, square;  ///< (xi A)^2 = constant + linear v + square v^2
  double A;
  double w_n_T;  ///< sqrt(1 - b^2) n T
  double fold_speed() const { return -linear / (2.0 * square); }
  double xi(double v) const { return std::sqrt(constant + linear * v + square * v * v) / A; }
  double xi_fold() const { return xi(fold_speed()); }
  double xi_grazing() const { return xi(0.0); }
};

inline Family family(const Oscillator& o) {
  const double T = 2.0 * std::numbers::pi * o.n / o.eta, w = std::sqrt(1.0 - o.b * o.b);
  const double c = std::cos(w * T), s = std::sin(w * T) / w;
  Eigen::Matrix2d Phi;
  Phi << c + o.b * s, s, -s, c - o.b * s;
  Phi *= std::exp(-o.b * T);
  const Eigen::Matrix2d solve = (Eigen::Matrix2d::Identity() - Phi).inverse();
  const Eigen::Vector2d P0 = solve * (Eigen::Vector2d(o.r, 0.0) - Phi * Eigen::Vector2d(o.r, 0.0));
  const Eigen::Vector2d P1 = solve * (Eigen::Vector2d(0.0, 1.0) + Phi * Eigen::Vector2d(0.0, o.k_r));
  const auto dot = [&](const Eigen::Vector2d& p, const Eigen::Vector2d& q) { return p[0] * q[0] + p[1] * q[1] / (o.eta * o.eta); };
  const double D = std::pow(1.0 - o.eta * o.eta, 2) + std::pow(2.0 * o.b * o.eta, 2);
  return {dot(P0, P0), 2.0 * dot(P0, P1), dot(P1, P1), 1.0 / std::sqrt(D), w * T};
}

}  // namespace one_impact
