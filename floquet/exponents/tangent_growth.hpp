// SPDX-License-Identifier: GPL-3.0-or-later
// How much the tangent of a motion may grow that settles on a stable orbit.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <Eigen/Eigenvalues>

#include <limits>

namespace graze {

/// A return whose tangent grows by more than this is not one to a stable orbit: its distance cannot account for that. Nor is a
/// motion on its way to one whose tangent has grown so much after long_enough periods (chaos with an exponent of 0.054 a period).
inline constexpr double hopeless_growth = 1e3;
inline constexpr int long_enough = 128;

/// The largest modulus of its eigenvalues; NaN where they cannot be found.
inline double spectral_radius(const Matrix& A) {
  if (!A.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return A.eigenvalues().cwiseAbs().maxCoeff();
}

}  // namespace graze
