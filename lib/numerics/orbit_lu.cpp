// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/numerics/orbit_lu.hpp>

#include <Eigen/LU>
#include <Eigen/SparseLU>

#include <cmath>
#include <limits>
#include <optional>

namespace graze {

template <class SquareMatrix> struct OrbitLU<SquareMatrix>::Factors {
  using Scalar = typename SquareMatrix::Scalar;

  explicit Factors(const SquareMatrix& A) {
    constexpr Eigen::Index small = 96;  // up to this size dense factors are as fast
    if (A.rows() > small && A.allFinite()) {
      Eigen::SparseMatrix<Scalar> entries = A.sparseView();
      entries.makeCompressed();
      sparse.emplace().compute(entries);
      if (sparse->info() == Eigen::Success) return;
      sparse.reset();  // exactly singular: dense factors give infinities, which callers test for
    }
    dense.compute(A);
  }

  Eigen::PartialPivLU<SquareMatrix> dense;
  std::optional<Eigen::SparseLU<Eigen::SparseMatrix<Scalar>>> sparse;
};

template <class SquareMatrix> OrbitLU<SquareMatrix>::OrbitLU(const SquareMatrix& A) : factors_(std::make_unique<Factors>(A)) {}

template <class SquareMatrix> OrbitLU<SquareMatrix>::~OrbitLU() = default;

template <class SquareMatrix> auto OrbitLU<SquareMatrix>::solve(const Column& right) const -> Column {
  return factors_->sparse ? Column(factors_->sparse->solve(right)) : Column(factors_->dense.solve(right));
}

template <class SquareMatrix> auto OrbitLU<SquareMatrix>::solve_adjoint(const Column& right) const -> Column {
  return factors_->sparse ? Column(factors_->sparse->adjoint().solve(right)) : Column(factors_->dense.adjoint().solve(right));
}

template <class SquareMatrix> bool OrbitLU<SquareMatrix>::is_invertible(const SquareMatrix& A) const {
  const Eigen::Index n = A.rows();
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  Column right(n);
  for (Eigen::Index i = 0; i < n; ++i) right[i] = 0.5 + std::fmod(static_cast<double>(i + 1) * golden, 1.0);
  const double length = solve(right).cwiseAbs().maxCoeff();
  const double rounding = static_cast<double>(n) * std::numeric_limits<double>::epsilon();
  return length * A.cwiseAbs().maxCoeff() * rounding < 1.0;  // false for NaN
}

template <class SquareMatrix>
double OrbitLU<SquareMatrix>::sign_of_determinant() const requires std::same_as<typename SquareMatrix::Scalar, double> {
  if constexpr (std::same_as<typename SquareMatrix::Scalar, double>) {  // (clang 14 compiles the other too)
    if (factors_->sparse) return factors_->sparse->signDeterminant();
    double sign = static_cast<double>(factors_->dense.permutationP().determinant());
    for (const double pivot : factors_->dense.matrixLU().diagonal()) sign *= pivot > 0.0 ? 1.0 : pivot < 0.0 ? -1.0 : 0.0;
    return sign;
  }
  return 0.0;
}

template class OrbitLU<Matrix>;
template class OrbitLU<Eigen::MatrixXcd>;

}  // namespace graze
