// SPDX-License-Identifier: GPL-3.0-or-later
// Tests of the helper that checks every Jacobian: it must reject wrong ones.
#include "support/checks.hpp"

using namespace graze;
using namespace graze::support;

namespace {

Vector curve(const Vector& x) { return vector({std::sin(x[0]) * x[1], std::exp(0.5 * x[0]) + x[1] * x[1] * x[1], x[0]}); }

Matrix slope(const Vector& x) {
  Matrix J(3, 2);
  J << std::cos(x[0]) * x[1], std::sin(x[0]), 0.5 * std::exp(0.5 * x[0]), 3.0 * x[1] * x[1], 1.0, 0.0;
  return J;
}

}  // namespace

TEST_CASE("a correct Jacobian passes the check with an accurate estimate of its error") {
  const Vector x = vector({0.7, -1.3});
  const JacobianCheck check = check_jacobian(curve, x, slope(x));
  REQUIRE(check.agrees(1e-11));
  REQUIRE(check.disagreement <= check.error_estimate);
  REQUIRE((central_differences(curve, x) - slope(x)).norm() < 1e-11);
  // Fourth order: halving the step divides the error by 16.
  const double coarse = (central_differences(curve, x, 0.2) - slope(x)).norm();
  const double fine = (central_differences(curve, x, 0.1) - slope(x)).norm();
  REQUIRE(coarse / fine == Approx(16.0).epsilon(0.1));
}

TEST_CASE("a wrong entry, a wrong sign and a transposed matrix are detected and named") {
  const Vector x = vector({0.7, -1.3});
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 2; ++j) {
      Matrix J = slope(x);
      J(i, j) += 1e-6;
      const JacobianCheck check = check_jacobian(curve, x, J);
      REQUIRE_FALSE(check.agrees(1e-8));
      REQUIRE(check.row == i);
      REQUIRE(check.column == j);
      REQUIRE(check.message.find(fmt::format("entry ({}, {}): given ", i, j)) == 0);
    }
  }
  REQUIRE_FALSE(check_jacobian(curve, x, -slope(x)).agrees(1e-3));
  REQUIRE_FALSE(check_jacobian(curve, x, slope(x).transpose()).agrees(1e300));
}

TEST_CASE("a Jacobian or a function that is not finite never agrees") {
  const Vector x = vector({0.7, -1.3});
  Matrix J = slope(x);
  J(1, 1) = std::nan("");
  const JacobianCheck check = check_jacobian(curve, x, J);
  REQUIRE_FALSE(check.agrees(1e300));
  REQUIRE(check.message == "the Jacobian is 3 x 2, central differences are 3 x 2; or one of them is not finite");
  const auto root = [](const Vector& z) { return Vector::Constant(1, std::sqrt(z[0])).eval(); };
  REQUIRE_FALSE(check_jacobian(root, vector({0.0}), Matrix::Ones(1, 1)).agrees(1e300));
}

TEST_CASE("steps grow with the argument and an empty Jacobian agrees") {
  const auto square = [](const Vector& z) { return Vector::Constant(1, z[0] * z[0]).eval(); };
  REQUIRE(check_jacobian(square, vector({1e8}), Matrix::Constant(1, 1, 2e8)).agrees(1e-9));
  REQUIRE(check_jacobian(square, vector({1.0}), Matrix::Constant(1, 1, 2.0)).agrees(1e-12));
  const auto constant = [](const Vector&) { return Vector::Ones(2).eval(); };
  REQUIRE(check_jacobian(constant, Vector(0), Matrix(2, 0)).agrees(0.0));
}
