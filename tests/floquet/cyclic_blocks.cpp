// SPDX-License-Identifier: GPL-3.0-or-later
// The cyclic equations of a Newton step, against the same equations as one dense matrix.
#include <graze/lib/numerics/cyclic_blocks.hpp>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include <random>

using namespace graze;

TEST_CASE("cyclic blocks: the solution agrees with that of the dense equations") {
  std::mt19937_64 generator(11);
  std::normal_distribution<double> normal;
  CyclicBlocks blocks;
  for (const double size : {0.3, 1.0, 30.0})  // products from 1e-30 to 1e90: elimination must not form them
    for (const int n : {1, 2, 3, 7, 64}) {
      std::vector<Matrix> Phi;
      Matrix r = Matrix::NullaryExpr(2, n, [&] { return normal(generator); }), d;
      Matrix A = Matrix::Zero(2 * n, 2 * n);
      for (int k = 0; k < n; ++k) {
        Phi.emplace_back(Matrix::NullaryExpr(2, 2, [&] { return size * normal(generator); }));
        A.block(2 * k, 2 * k, 2, 2) += Phi.back();
        A.block(2 * k, 2 * ((k + 1) % n), 2, 2) -= Eigen::Matrix2d::Identity();
      }
      const Vector b = -r.reshaped();
      blocks.solve(Phi, r, d);
      REQUIRE(d.size() == r.size());
      const Vector found = d.reshaped();
      const Eigen::VectorXd exact = A.fullPivLu().solve(b);
      INFO("n " << n << " size " << size);
      // Backward stable: the error is rounding times the condition number.
      const Eigen::VectorXd singular = A.jacobiSvd().singularValues();
      const double condition = singular[0] / singular[2 * n - 1];
      CHECK((found - exact).norm() < 1e-14 * condition * (1.0 + exact.norm()));
      CHECK((A * found - b).norm() < 1e-13 * (A.norm() * found.norm() + b.norm()));
    }
}

TEST_CASE("cyclic blocks: a singular matrix gives no finite solution") {
  CyclicBlocks blocks;
  Matrix d;
  blocks.solve({Matrix::Identity(2, 2)}, Matrix::Ones(2, 1), d);
  CHECK_FALSE(std::isfinite(d(0, 0)));
}
