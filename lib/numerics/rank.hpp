// SPDX-License-Identifier: GPL-3.0-or-later
// Rank and determinant of a small square matrix whose entries carry rounding.
#pragma once

#include <graze/lib/numerics/vector.hpp>

namespace graze {

struct RankedDeterminant {
  double value = 0.0;           ///< exactly zero for a matrix of deficient rank
  Eigen::Index deficiency = 0;  ///< number of rows minus the rank
};

/// The rank does not depend on the scales of rows and columns: near grazing a saltation matrix has an entry like 1/speed without
/// being singular.
RankedDeterminant ranked_determinant(const Matrix& A);

inline Eigen::Index rank_deficiency(const Matrix& A) { return ranked_determinant(A).deficiency; }

}  // namespace graze
