// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/system/jacobian_check.hpp>

#include <fmt/format.h>

#include <cmath>

namespace graze {

namespace {

Vector central_column(const std::function<Vector(const Vector&)>& f, const Vector& x, Eigen::Index j, double h) {
  Vector ahead = x, behind = x;
  ahead[j] += h;
  behind[j] -= h;
  return (f(ahead) - f(behind)) / (ahead[j] - behind[j]);
}

/// The extrapolated differences, and the estimate of their error from the last extrapolation.
std::pair<Matrix, Matrix> differences(const std::function<Vector(const Vector&)>& f, const Vector& x, double step) {
  const Eigen::Index rows = f(x).size();
  Matrix value(rows, x.size()), error(rows, x.size());
  for (Eigen::Index j = 0; j < x.size(); ++j) {
    const double h = step * (1.0 + std::abs(x[j]));
    const Vector coarse = central_column(f, x, j, h), fine = central_column(f, x, j, h / 2);
    value.col(j) = (4.0 * fine - coarse) / 3.0;
    // Once h^2 dominates, the error of the extrapolated value is far below this difference; a tenth of it is still an upper
    // bound.
    error.col(j) = 0.1 * (fine - coarse).cwiseAbs();
  }
  return {value, error};
}

}  // namespace

Matrix central_differences(const std::function<Vector(const Vector&)>& f, const Vector& x, double step) {
  return differences(f, x, step).first;
}

bool JacobianCheck::agrees(double tolerance) const { return disagreement <= tolerance; }

JacobianCheck check_jacobian(const std::function<Vector(const Vector&)>& f, const Vector& x, const Matrix& jacobian,
                             double step) {
  const auto [value, error] = differences(f, x, step);
  JacobianCheck check;
  if (value.rows() != jacobian.rows() || value.cols() != jacobian.cols() || !jacobian.allFinite() || !value.allFinite()) {
    check.disagreement = std::numeric_limits<double>::infinity();
    check.message = fmt::format("the Jacobian is {} x {}, central differences are {} x {}; or one of them is not finite",
                                jacobian.rows(), jacobian.cols(), value.rows(), value.cols());
    return check;
  }
  if (jacobian.size() == 0) return check;
  const double scale = 1.0 + jacobian.cwiseAbs().maxCoeff();
  check.disagreement = (jacobian - value).cwiseAbs().maxCoeff(&check.row, &check.column) / scale;
  check.error_estimate = error.maxCoeff() / scale;
  check.message = fmt::format("entry ({}, {}): given {:.15g}, central differences {:.15g}", check.row, check.column,
                              jacobian(check.row, check.column), value(check.row, check.column));
  return check;
}

}  // namespace graze
