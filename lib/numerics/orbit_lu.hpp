// SPDX-License-Identifier: GPL-3.0-or-later
// OrbitLU: LU factors of the square, bordered matrices of an orbit's equations. Each node couples to the next one only, so that
// with many nodes the matrix is sparse. Sparse factors then cost time proportional to the number of nodes, not to its cube.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <concepts>
#include <memory>

namespace graze {

/// Of a Matrix or an Eigen::MatrixXcd, for which it is compiled.
template <class SquareMatrix> class OrbitLU {
 public:
  using Column = Eigen::Matrix<typename SquareMatrix::Scalar, Eigen::Dynamic, 1>;

  explicit OrbitLU(const SquareMatrix& A);
  ~OrbitLU();

  /// A^{-1} right; not finite where A is singular.
  Column solve(const Column& right) const;
  Column solve_adjoint(const Column& right) const;
  /// Whether A, given once more, is invertible beyond rounding: a right side without structure has a solution of moderate size.
  bool is_invertible(const SquareMatrix& A) const;
  /// The sign of det A of a real matrix: 1, -1, or 0 where A is singular.
  double sign_of_determinant() const requires std::same_as<typename SquareMatrix::Scalar, double>;

 private:
  struct Factors;
  std::unique_ptr<Factors> factors_;
};

extern template class OrbitLU<Matrix>;
extern template class OrbitLU<Eigen::MatrixXcd>;

}  // namespace graze
