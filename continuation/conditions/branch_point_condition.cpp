// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/branch_point_condition.hpp>

#include <graze/lib/numerics/null_vectors.hpp>

#include <cmath>

namespace graze {

namespace {

/// The residual (H + e b, g, w^T H_p) at u for fixed borders b and c, with the unfolding parameter e and H_p per `unit` of the
/// parameter. Writes the null vector v to `null` unless it is null. Empty if the equations cannot be evaluated.
Vector extended_residual(const ZeroProblem& problem, double unit, const Vector& u, double unfolding, const Vector& b,
                         const Vector& c, Vector* null) {
  Vector residual;
  Matrix jacobian;
  if (!problem.evaluate(u, residual, &jacobian)) return {};
  const Eigen::Index size = residual.size();
  Matrix A = Matrix::Zero(size + 1, size + 1);
  A.topLeftCorner(size, size) = jacobian.leftCols(size);
  A.col(size).head(size) = b;
  A.row(size).head(size) = c.transpose();
  const Vector right = Vector::Unit(size + 1, size);
  const OrbitLU<Matrix> lu(A);
  const Vector v = lu.solve(right), w = lu.solve_adjoint(right);
  if (null) *null = v.head(size);
  Vector out(size + 2);
  out << residual + unfolding * b, v[size], unit * w.head(size).dot(jacobian.col(size));
  return out;
}

}  // namespace

LocatedPoint locate_branch_point(BranchProblem& problem, const Vector& start) {
  require_one_parameter(problem);
  LocatedPoint located;
  located.u = start;
  Vector residual;
  Matrix jacobian;
  located.newton.status = NewtonStatus::evaluation_failed;
  const ZeroProblem zero = problem.zero_problem();
  if (!zero.evaluate(start, residual, &jacobian)) return located;
  const Eigen::Index size = residual.size();
  const auto [c, b] = null_vectors(Matrix(jacobian.leftCols(size)));
  const double scale = problem.state_scale(start), unit = problem.unit();
  Vector null, F, row;
  double last_step = 0.0;
  const auto linearise = [&, &b = b, &c = c](const Vector& v) -> std::optional<NewtonIterate> {
    const Vector u = v.head(size + 1);
    const double unfolding = v[size + 1];
    F = extended_residual(zero, unit, u, unfolding, b, c, &null);
    if (F.size() == 0) return std::nullopt;
    Matrix J(size + 2, size + 2);
    for (Eigen::Index i = 0; i <= size; ++i) {
      const double h = 1e-6 * problem.size_of_unknown(u, i);
      Vector ahead = u, behind = u;
      ahead[i] += h;
      behind[i] -= h;
      const Vector fa = extended_residual(zero, unit, ahead, unfolding, b, c, nullptr);
      const Vector fb = extended_residual(zero, unit, behind, unfolding, b, c, nullptr);
      if (fa.size() == 0 || fb.size() == 0) return std::nullopt;
      J.col(i) = (fa - fb) / (2.0 * h);
    }
    J.col(size + 1) << b, 0.0, 0.0;
    const OrbitLU<Matrix> lu(J);
    NewtonIterate at;
    at.residual = F.lpNorm<Eigen::Infinity>() / scale;
    at.step = lu.solve(-F);
    at.length = problem.largest_change(at.step.head(size + 1)) / scale;
    row = lu.solve_adjoint(Vector::Unit(size + 2, size));
    last_step = at.step[size];
    return at;
  };
  Vector v(size + 2);
  v << start, 0.0;
  // Looser tolerances than the default: the Jacobian is formed by finite differences, which limits the accuracy.
  located.newton = newton_to_rounding(v, linearise, {.acceptance = 1e-9, .shortest = 1e-13});
  located.u = v.head(size + 1);
  if (null.size() > 0) located.v = null.cast<std::complex<double>>();
  if (!located.newton.converged()) return located;
  const double unfolding = v[size + 1];
  // Solved with an unfolding, the equations have no branch point here: as a method for that point Newton's has stalled.
  if (!(std::abs(unfolding) < 1e-8)) located.newton.status = NewtonStatus::stalled;
  // Newton's method does not take its last step, so the length of that step estimates the remaining error.
  located.precision = std::abs(last_step) + 1e-13 * problem.size_of_value(located.u[size]);
  const double by_steps = error_of_steps(problem, row, F, [&, &b = b, &c = c](BranchProblem& finer) {
    return extended_residual(finer.zero_problem(), unit, located.u, unfolding, b, c, nullptr);
  });
  located.precision = std::max(located.precision, by_steps);
  return located;
}

}  // namespace graze
