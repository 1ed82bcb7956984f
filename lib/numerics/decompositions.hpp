// SPDX-License-Identifier: GPL-3.0-or-later
// Decompositions of matrices of any size that several rooms need. Eigen's templates for them are large; here they are compiled
// once.
#pragma once

#include <graze/lib/numerics/vector.hpp>

namespace graze {

/// Of a real square matrix with finite entries, each as often as its algebraic multiplicity.
Eigen::VectorXcd eigenvalues(const Matrix& A);

/// The largest modulus of the eigenvalues; NaN if A is not finite.
double spectral_radius(const Matrix& A);

/// Condition number (2-norm) of the unit eigenvectors of a square matrix; infinite if it is defective.
double eigenvector_condition(const Matrix& A);

/// The least-squares solution x of A x = b of smallest norm. Pivots below `threshold` times the largest count as zero; without
/// it, those below rounding.
Vector shortest_solution(const Matrix& A, const Vector& b, double threshold = 0.0);

}  // namespace graze
