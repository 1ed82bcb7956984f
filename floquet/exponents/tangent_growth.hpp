// SPDX-License-Identifier: GPL-3.0-or-later
// Largest growth of the tangent of a motion that settles on a stable orbit.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <Eigen/Eigenvalues>

#include <limits>

namespace graze {

/// A return whose tangent grows by more than max_growth does not lead to a stable orbit: its distance cannot explain such
/// growth. The same holds for a motion whose tangent has grown this much after growth_test_periods periods (chaos with an
/// exponent of 0.054 a period).
inline constexpr double max_growth = 1e3;
inline constexpr int growth_test_periods = 128;

/// The largest modulus of the eigenvalues of A; NaN if A is not finite.
inline double spectral_radius(const Matrix& A) {
  if (!A.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return A.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace graze
