// SPDX-License-Identifier: GPL-3.0-or-later
// Compares any Jacobian with central differences, entry by entry. Public: users check their own models with it.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <functional>
#include <string>

namespace graze {

/// Result of a comparison: the largest |J - J_fd| / (1 + max|J|), its entry, and the estimated error of the differences.
struct JacobianCheck {
  double disagreement = 0.0;    ///< relative to 1 + max|J|
  double error_estimate = 0.0;  ///< of the Richardson extrapolation, on the same scale
  Eigen::Index row = 0, column = 0;
  bool agrees(double tolerance) const;
  /// "entry (row, column): given ..., central differences ...".
  std::string message;
};

/// Central differences with one Richardson step, (4 D(h/2) - D(h)) / 3, h = step (1 + |x_j|).
Matrix central_differences(const std::function<Vector(const Vector&)>& f, const Vector& x, double step = 1e-3);

/// Compares `jacobian` with central differences of f at x.
JacobianCheck check_jacobian(const std::function<Vector(const Vector&)>& f, const Vector& x, const Matrix& jacobian,
                             double step = 1e-3);

}  // namespace graze
