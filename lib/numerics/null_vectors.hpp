// SPDX-License-Identifier: GPL-3.0-or-later
// Null vectors of a (nearly) singular square matrix A, which make a bordered system regular, and its solution:
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

/// The solution of a bordered system, and w of the adjoint one:
///     [A    b] [v]   [0]        [A^H  c] [w]   [0]
///     [c^H  0] [g] = [1],       [b^H  0] [.] = [1].
template <class SquareMatrix> struct BorderedSolution {
  typename SquareMatrix::Scalar g;
  typename NullVectors<SquareMatrix>::Column v, w;
};

template <class SquareMatrix>
BorderedSolution<SquareMatrix> solve_bordered(const SquareMatrix& A, const typename NullVectors<SquareMatrix>::Column& b,
                                              const typename NullVectors<SquareMatrix>::Column& c) {
  using Column = typename NullVectors<SquareMatrix>::Column;
  const Eigen::Index size = A.rows();
  SquareMatrix bordered = SquareMatrix::Zero(size + 1, size + 1);
  bordered.topLeftCorner(size, size) = A;
  bordered.col(size).head(size) = b;
  bordered.row(size).head(size) = c.adjoint();
  const Column right = Column::Unit(size + 1, size);
  const OrbitLU<SquareMatrix> lu(bordered);
  const Column direct = lu.solve(right), adjoint = lu.solve_adjoint(right);
  return {direct[size], direct.head(size), adjoint.head(size)};
}

}  // namespace graze
