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
      std::vector<CyclicBlocks::Square> Phi(static_cast<std::size_t>(n));
      std::vector<CyclicBlocks::Pair> r(Phi.size()), d;
      Eigen::MatrixXd A = Eigen::MatrixXd::Zero(2 * n, 2 * n);
      Eigen::VectorXd b(2 * n);
      for (int k = 0; k < n; ++k) {
        const auto i = static_cast<std::size_t>(k);
        for (double& entry : Phi[i]) entry = size * normal(generator);
        for (double& entry : r[i]) entry = normal(generator);
        A.block(2 * k, 2 * k, 2, 2) += Eigen::Map<Eigen::Matrix<double, 2, 2, Eigen::RowMajor>>(Phi[i].data());
        A.block(2 * k, 2 * ((k + 1) % n), 2, 2) -= Eigen::Matrix2d::Identity();
        b.segment(2 * k, 2) = -Eigen::Map<Eigen::Vector2d>(r[i].data());
      }
      blocks.solve(Phi, r, d);
      REQUIRE(d.size() == r.size());
      const Eigen::Map<Eigen::VectorXd> found(d.front().data(), 2 * n);
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
  std::vector<CyclicBlocks::Pair> d;
  blocks.solve({{1.0, 0.0, 0.0, 1.0}}, {{1.0, 1.0}}, d);
  CHECK_FALSE(std::isfinite(d[0][0]));
}
