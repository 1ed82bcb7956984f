// SPDX-License-Identifier: GPL-3.0-or-later
// ZeroProblem: H(u) = 0 with fewer equations than unknowns. The tracer follows the curves of its solutions if there is one
// equation fewer. With several equations fewer, conditions are to be added first.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace graze {

/// Limits of an unknown: H cannot be evaluated beyond `lower` and `upper`. A step that would pass one of them ends at `low` or
/// `high`, which lie within the limits.
struct UnknownLimits {
  Eigen::Index unknown = 0;
  double lower, upper, low, high;
  /// A step to an end that cannot be evaluated is not halved below this length: the tracer stops.
  double shortest = 0.0;
};

struct ZeroProblem {
  Eigen::Index unknowns = 0;
  /// Sets residual (m equations, for the tracer unknowns - 1) and, unless null, Jacobian (m x unknowns). False: H cannot be
  /// evaluated at u.
  std::function<bool(const Vector& u, Vector& residual, Matrix* jacobian)> evaluate;
  /// Weights of the arclength norm |u|^2 = sum w_i u_i^2; empty: all 1.
  Vector weights;
  /// Tolerances of the residual are relative to this: the size of the quantities whose difference the residual is.
  double size = 1.0;
  /// None: the steps are not limited.
  std::vector<UnknownLimits> limits = {};
  /// Text: why the last evaluation failed; may be empty.
  std::function<std::string()> failure;
};

/// |v| in the arclength norm of these weights.
inline double weighted_norm(const Vector& weights, const Vector& v) { return std::sqrt(weights.dot(v.cwiseAbs2())); }

}  // namespace graze
