// SPDX-License-Identifier: GPL-3.0-or-later
// Norms, distances (in the maximum norm) and weighted sums of states, for vectors and for the number pairs in the lanes.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace graze {

using StatePair = std::array<double, 2>;

inline StatePair pair_of(const Vector& state) { return {state[0], state[1]}; }
inline Vector vector_of(const StatePair& state) { return Vector{{state[0], state[1]}}; }

inline double state_size(const Vector& x) { return x.lpNorm<Eigen::Infinity>(); }
inline double state_size(const StatePair& x) { return std::max(std::abs(x[0]), std::abs(x[1])); }

inline double state_distance(const Vector& a, const Vector& b) { return (a - b).lpNorm<Eigen::Infinity>(); }
inline double state_distance(const StatePair& a, const StatePair& b) { return state_size(StatePair{a[0] - b[0], a[1] - b[1]}); }

inline Vector weighted(double a, const Vector& x, double b, const Vector& y) { return a * x + b * y; }
inline StatePair weighted(double a, const StatePair& x, double b, const StatePair& y) {
  return {a * x[0] + b * y[0], a * x[1] + b * y[1]};
}

/// Distance to the nearest of several states; infinite if there are none.
template <class States, class State> double nearest_distance(const States& states, const State& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& state : states) least = std::min(least, state_distance(state, x));
  return least;
}

}  // namespace graze
