// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/defining_equations.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>
#include <graze/lib/tasks/newton_loop.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

Vector start_of(const DefiningEquations& equations, const Vector& u) {
  const Vector own = equations.own_start();
  Vector w(u.size() + own.size());
  w << u, own;
  return w;
}

DefinedPoint solve(BranchProblem& problem, DefiningEquations& equations, const Vector& u) {
  require_one_parameter(problem);
  const Eigen::Index unknowns = problem.unknowns(), parameter = problem.orbit_unknowns();
  DefinedPoint at;
  at.w = start_of(equations, u);
  Matrix jacobian;
  const auto residual = [&](const Vector& w) -> std::optional<double> {
    if (!equations.evaluate(problem, w, at.F, &jacobian)) return std::nullopt;
    return at.F.cwiseQuotient(equations.sizes()).lpNorm<Eigen::Infinity>();
  };
  const auto step_at = [&](const Vector& w, Vector& step) -> NewtonStep {
    const OrbitLU<Matrix> lu(jacobian);
    step = lu.solve(-at.F);
    if (!step.allFinite()) return {};
    at.row = lu.solve_adjoint(Vector::Unit(w.size(), parameter));
    at.last_step = step[parameter];
    const Vector own = step.tail(w.size() - unknowns);
    const double scale = problem.state_scale(w.head(unknowns));
    const double length = std::max(problem.largest_change(step.head(unknowns)), own.size() ? own.lpNorm<Eigen::Infinity>() : 0.0);
    return {.length = length, .size = scale, .may_be_last = equations.may_end(problem, w, length / scale)};
  };
  at.newton = newton(at.w, residual, step_at, equations.rule());
  return at;
}

LocatedPoint locate(BranchProblem& problem, DefiningEquations& equations, const Vector& u) {
  const DefinedPoint at = solve(problem, equations, u);
  LocatedPoint located;
  located.newton = at.newton;
  located.u = at.w.head(problem.unknowns());
  equations.describe(at.w, located);
  if (!at.newton.converged()) return located;
  // Effects on the parameter: of rounding in each equation, and of the flow's steps, from the equations at the solution with
  // steps half as long. An error of the steps below half of the rounding is covered by it.
  located.precision = rounding_of_equations * at.row.cwiseProduct(equations.sizes()).lpNorm<1>();
  Vector finer;
  if (equations.evaluate(*problem.with_half_steps(), at.w, finer, nullptr) && finer.allFinite())
    located.precision = std::max(located.precision, 2.0 * std::abs(at.row.dot(finer - at.F)));
  const double left = std::abs(at.last_step);
  if (left > located.precision) located.precision += left;
  return located;
}

ZeroProblem curve_of(BranchProblem& problem, DefiningEquations& equations) {
  ZeroProblem curve = problem.zero_problem();
  const Eigen::Index own = equations.own_start().size();
  curve.unknowns += own;
  curve.weights.conservativeResize(curve.unknowns);
  curve.weights.tail(own).setOnes();
  curve.evaluate = [&problem, &equations, size = curve.size](const Vector& w, Vector& F, Matrix* jacobian) {
    Matrix unused;
    Matrix& J = jacobian ? *jacobian : unused;
    if (!equations.evaluate(problem, w, F, &J)) return false;
    const Vector scales = size * equations.sizes().cwiseInverse();
    F = scales.cwiseProduct(F);
    J = scales.asDiagonal() * J;
    return F.allFinite() && J.allFinite();
  };
  return curve;
}

}  // namespace graze
