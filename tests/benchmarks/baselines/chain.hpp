// SPDX-License-Identifier: GPL-3.0-or-later
// A chain of m equal masses, each on its own spring and coupled to the next. The first one is forced and in front of a rigid
// stop:
//     x_i'' + 2 b x_i' + x_i + kappa sum over its neighbours (x_i - x_j) = [i = 1] xi cos(eta t),   x_1 <= r.
// Written by hand like the other baselines, with its integration loop. State: (x_1, x_1', x_2, x_2', ...), and on request the
// sensitivity Phi by columns.
#pragma once

#include "oscillator.hpp"

namespace baselines {

template <std::size_t masses> struct ChainParameters { double b = 0.05, kappa = 0.5, xi = 1.0, eta = 0.711, r = 1.0, k_r = 0.8; };

template <std::size_t masses, bool sensitivity> struct ChainField {
  static constexpr std::size_t states = 2 * masses, size = states + (sensitivity ? states * states : 0);
  using Parameters = ChainParameters<masses>;
  Parameters p;
  bool in_contact = false;  ///< never: a rigid stop

  /// Field without forcing, for the motion and for each column of Phi.
  void pull(const double* u, double* du) const {
    for (std::size_t i = 0; i < masses; ++i) {
      const double here = u[2 * i];
      double a = -2.0 * p.b * u[2 * i + 1] - here;
      if (i > 0) a -= p.kappa * (here - u[2 * i - 2]);
      if (i + 1 < masses) a -= p.kappa * (here - u[2 * i + 2]);
      du[2 * i] = u[2 * i + 1];
      du[2 * i + 1] = a;
    }
  }
  void operator()(double t, const double* u, double* du) const {
    for (std::size_t column = 0; column < size; column += states) pull(u + column, du + column);
    du[1] += p.xi * std::cos(p.eta * t);
  }
  double direction() const { return 1.0; }
};

/// x_1' -> -k_r x_1' at the stop, and the columns of Phi by its saltation matrix. Only the first mass has an impact, and its
/// speed enters no other acceleration. All rows but two are therefore those of the identity.
template <std::size_t masses> void strike(const ChainParameters<masses>& p, double t, State<ChainField<masses, true>::size>& u) {
  using Field = ChainField<masses, true>;
  const double v = u[1], w = -p.k_r * v;
  u[0] = p.r;
  const auto acceleration = [&](double speed) {
    double a = p.xi * std::cos(p.eta * t) - 2.0 * p.b * speed - p.r;
    if constexpr (masses > 1) a -= p.kappa * (p.r - u[2]);
    return a;
  };
  const double jump = (acceleration(w) + p.k_r * acceleration(v)) / v;
  u[1] = w;
  for (std::size_t column = Field::states; column < Field::size; column += Field::states) {
    u[column + 1] = jump * u[column] - p.k_r * u[column + 1];
    u[column] *= -p.k_r;
  }
}

}  // namespace baselines
