// SPDX-License-Identifier: GPL-3.0-or-later
// OrbitLU: LU factors of the square, bordered matrices of an orbit's equations. Each node couples to the next one only, so that
// with many nodes the matrix is sparse. Sparse factors then cost time proportional to the number of nodes, not to its cube.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <Eigen/LU>
#include <Eigen/SparseLU>

#include <memory>

namespace graze {

template <class SquareMatrix> class OrbitLU {
 public:
  using Scalar = typename SquareMatrix::Scalar;
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  explicit OrbitLU(const SquareMatrix& A) {
    constexpr Eigen::Index small = 96;  // up to this size dense factors are as fast
    if (A.rows() > small && A.allFinite()) {
      sparse_ = std::make_unique<Sparse>();
      Eigen::SparseMatrix<Scalar> entries = A.sparseView();
      entries.makeCompressed();
      sparse_->compute(entries);
      if (sparse_->info() == Eigen::Success) return;
      sparse_.reset();  // exactly singular: dense factors give infinities, which callers test for
    }
    dense_.compute(A);
  }

  Column solve(const Column& right) const { return sparse_ ? Column(sparse_->solve(right)) : Column(dense_.solve(right)); }
  Column solve_adjoint(const Column& right) const {
    return sparse_ ? Column(sparse_->adjoint().solve(right)) : Column(dense_.adjoint().solve(right));
  }

 private:
  using Sparse = Eigen::SparseLU<Eigen::SparseMatrix<Scalar>>;
  Eigen::PartialPivLU<SquareMatrix> dense_;
  std::unique_ptr<Sparse> sparse_;
};

}  // namespace graze
