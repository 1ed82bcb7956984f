// SPDX-License-Identifier: GPL-3.0-or-later
// OrbitLU: LU factors of the square matrices of an orbit's equations with their borders. Each node is linked to the next one
// only, so that with many nodes most of the matrix is zero: then the factors are sparse, at a cost that grows with the number of
// nodes and not with its cube.
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
    constexpr Eigen::Index small = 96;  // up to there dense factors are as fast
    if (A.rows() > small && A.allFinite()) {
      sparse_ = std::make_unique<Sparse>();
      Eigen::SparseMatrix<Scalar> entries = A.sparseView();
      entries.makeCompressed();
      sparse_->compute(entries);
      if (sparse_->info() == Eigen::Success) return;
      sparse_.reset();  // singular to the last bit: dense factors give infinities, which callers look for
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
