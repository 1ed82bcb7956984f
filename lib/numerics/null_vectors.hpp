// SPDX-License-Identifier: GPL-3.0-or-later
// Null vectors of a (nearly) singular square matrix A, which make a bordered system regular:
//
//     right: A v ~ 0,   left: w^H A ~ 0,   |v| = |w| = 1.
//
// They are the singular vectors of A's smallest singular value, by inverse iteration with A^H A. They are only approximate if
// the next singular value is close, which suffices for borders (Govaerts, Numerical Methods for Bifurcations of Dynamical
// Equilibria, SIAM 2000, section 3.2). A may be exactly singular.
#pragma once

#include <graze/lib/numerics/orbit_lu.hpp>

#include <cmath>

namespace graze {

template <class SquareMatrix> struct NullVectors {
  using Column = Eigen::Matrix<typename SquareMatrix::Scalar, Eigen::Dynamic, 1>;
  Column right, left;
};

template <class SquareMatrix> NullVectors<SquareMatrix> null_vectors(const SquareMatrix& A) {
  NullVectors<SquareMatrix> null;
  const Eigen::Index n = A.rows();
  // A shift too small to affect the borders keeps the solutions finite if A is exactly singular, and their squares finite if A
  // is zero.
  const double shift = 1e-13 * A.cwiseAbs().maxCoeff() + 1e-100;
  SquareMatrix shifted = A;
  shifted.diagonal().array() += shift;
  const OrbitLU<SquareMatrix> lu(shifted);
  null.right.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) null.right[i] = 1.0 + 0.5 * std::cos(1.7 * static_cast<double>(i) + 0.3);
  for (int iteration = 0; iteration < 6; ++iteration) {
    null.left = lu.solve_adjoint(null.right).normalized();
    null.right = lu.solve(null.left).normalized();
  }
  return null;
}

}  // namespace graze
