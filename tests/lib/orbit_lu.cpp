// SPDX-License-Identifier: GPL-3.0-or-later
// Factors of the matrices of an orbit's equations, dense for few unknowns and sparse for many, against Eigen's dense ones.
#include <graze/lib/numerics/orbit_lu.hpp>

#include <catch2/catch.hpp>

#include <Eigen/LU>

#include <random>

using namespace graze;

namespace {

/// The cyclic matrix of an orbit with random blocks of 2 x 2.
Matrix random_cyclic(Eigen::Index nodes, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Matrix A = Matrix::Zero(2 * nodes, 2 * nodes);
  for (Eigen::Index j = 0; j < nodes; ++j) {
    A.block(2 * j, 2 * j, 2, 2) = Matrix::NullaryExpr(2, 2, [&] { return uniform(random); });
    A.block(2 * j, 2 * ((j + 1) % nodes), 2, 2) -= Matrix::Identity(2, 2);
  }
  return A;
}

}  // namespace

TEST_CASE("solutions and the sign of the determinant agree with dense factors, for few nodes and for many") {
  std::mt19937 random(3);
  int negative = 0;
  for (const Eigen::Index nodes : {1, 2, 7, 48, 49, 80})
    for (int trial = 0; trial < 8; ++trial) {
      Matrix A = random_cyclic(nodes, random);
      if (trial % 2 == 1) A.row(0) = -A.row(0);
      INFO(nodes << " nodes, trial " << trial);
      const OrbitLU<Matrix> lu(A);
      const Eigen::FullPivLU<Matrix> dense(A);
      const Vector right = Vector::LinSpaced(A.rows(), 1.0, 2.0), x = lu.solve(right), y = lu.solve_adjoint(right);
      CHECK((A * x - right).lpNorm<Eigen::Infinity>() < 1e-10 * (1.0 + x.lpNorm<Eigen::Infinity>()));
      CHECK((A.transpose() * y - right).lpNorm<Eigen::Infinity>() < 1e-10 * (1.0 + y.lpNorm<Eigen::Infinity>()));
      const bool below = dense.determinant() < 0.0;
      CHECK(lu.is_invertible(A));
      CHECK(lu.sign_of_determinant() == (below ? -1.0 : 1.0));
      negative += below ? 1 : 0;
    }
  CHECK(negative > 10);
  CHECK(negative < 38);
  for (const Eigen::Index nodes : {1, 7, 80})
    for (const bool closed : {true, false}) {
      INFO(nodes << " nodes");
      Matrix A = random_cyclic(nodes, random);
      if (closed) {  // a column that is a combination of the others, up to rounding
        const Vector weights = Vector::LinSpaced(A.cols() - 1, -1.0, 1.0 / 3.0);
        A.col(A.cols() - 1) = A.leftCols(A.cols() - 1) * weights;
      } else {
        A.row(1).setZero();
      }
      CHECK_FALSE(OrbitLU<Matrix>(A).is_invertible(A));
      CHECK_FALSE(Eigen::FullPivLU<Matrix>(A).isInvertible());
    }
  Matrix singular = random_cyclic(3, random);
  singular.col(1).setZero();
  CHECK(OrbitLU<Matrix>(singular).sign_of_determinant() == 0.0);
}
