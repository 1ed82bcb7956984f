// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/branch_point_condition.hpp>

#include <graze/lib/numerics/null_vectors.hpp>

#include <cmath>

namespace graze {

namespace {

/// (H, g, w^T H_p) at u for fixed borders; empty where the equations cannot be evaluated.
Vector extended_residual(const ZeroProblem& problem, const Vector& u, double unfolding, const Vector& b, const Vector& c,
                         Vector* null) {
  Vector residual;
  Matrix jacobian;
  if (!problem.evaluate(u, residual, &jacobian)) return {};
  const Eigen::Index size = residual.size();
  Matrix A = Matrix::Zero(size + 1, size + 1);
  A.topLeftCorner(size, size) = jacobian.leftCols(size);
  A.col(size).head(size) = b;
  A.row(size).head(size) = c.transpose();
  const Vector unit = Vector::Unit(size + 1, size);
  const OrbitLU<Matrix> lu(A);
  const Vector v = lu.solve(unit), w = lu.solve_adjoint(unit);
  if (null) *null = v.head(size);
  Vector out(size + 2);
  out << residual + unfolding * b, v[size], w.head(size).dot(jacobian.col(size));
  return out;
}

}  // namespace

LocatedPoint locate_branch_point(BranchProblem& problem, const Vector& start) {
  LocatedPoint located;
  located.u = start;
  Vector residual;
  Matrix jacobian;
  located.newton.status = NewtonStatus::evaluation_failed;
  const ZeroProblem zero = problem.zero_problem();
  if (!zero.evaluate(start, residual, &jacobian)) return located;
  const Eigen::Index size = residual.size();
  const auto [c, b] = null_vectors(Matrix(jacobian.leftCols(size)));
  const double scale = problem.state_scale(start);
  double unfolding = 0.0, last_step = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 20; ++iteration) {
    Vector null;
    const Vector F = extended_residual(zero, located.u, unfolding, b, c, &null);
    if (F.size() == 0) return located;
    Matrix J(size + 2, size + 2);
    for (Eigen::Index i = 0; i <= size; ++i) {
      const double h = 1e-6 * (1.0 + std::abs(located.u[i]));
      Vector ahead = located.u, behind = located.u;
      ahead[i] += h;
      behind[i] -= h;
      const Vector fa = extended_residual(zero, ahead, unfolding, b, c, nullptr);
      const Vector fb = extended_residual(zero, behind, unfolding, b, c, nullptr);
      if (fa.size() == 0 || fb.size() == 0) return located;
      J.col(i) = (fa - fb) / (2.0 * h);
    }
    J.col(size + 1) << b, 0.0, 0.0;
    const Vector step = J.partialPivLu().solve(-F);
    located.newton.residual_history.push_back(F.lpNorm<Eigen::Infinity>() / scale);
    if (!step.allFinite()) {
      located.newton.status = NewtonStatus::singular;
      return located;
    }
    const double step_size = step.head(size + 1).lpNorm<Eigen::Infinity>() / scale;
    located.v = null.cast<std::complex<double>>();
    if (located.newton.residual() < 1e-9 && (step_size < 1e-13 || step_size >= 0.5 * last_step)) {
      located.newton.status = std::abs(unfolding) < 1e-8 ? NewtonStatus::converged : NewtonStatus::stalled;
      // The step is not taken: what is left of the error after it comes on top.
      located.precision = std::abs(step[size]) + 1e-13 * (1.0 + std::abs(located.u[size]));
      return located;
    }
    last_step = step_size;
    located.u += step.head(size + 1);
    unfolding += step[size + 1];
    located.newton.status = NewtonStatus::iteration_limit;
  }
  return located;
}

}  // namespace graze
