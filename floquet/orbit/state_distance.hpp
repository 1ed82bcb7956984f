// SPDX-License-Identifier: GPL-3.0-or-later
// Norms, distances (in the maximum norm) and weighted sums of states.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace graze {

inline double state_size(const Vector& x) { return x.lpNorm<Eigen::Infinity>(); }

inline double state_distance(const Vector& a, const Vector& b) { return (a - b).lpNorm<Eigen::Infinity>(); }

inline Vector weighted(double a, const Vector& x, double b, const Vector& y) { return a * x + b * y; }

/// Distance to the nearest of several states; infinite if there are none.
inline double nearest_distance(const std::vector<Vector>& states, const Vector& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector& state : states) least = std::min(least, state_distance(state, x));
  return least;
}

}  // namespace graze
