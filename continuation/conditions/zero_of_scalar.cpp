// SPDX-License-Identifier: GPL-3.0-or-later
// UZ: a scalar of the orbit, given by the user, is zero. Located by Newton's method on H(u) = 0, g(u) = 0. The gradient of g is
// formed by central differences, because g is known as a function of the orbit only.
#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/problems/branch_problem.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>

#include <cmath>
#include <limits>
#include <utility>

namespace graze {

namespace {

using Scalar = std::function<double(const BranchPoint& point)>;

LocatedPoint locate_zero(BranchProblem& problem, const Vector& start, const Scalar& scalar) {
  constexpr double difference_step = 1e-6;
  const ZeroProblem zero = problem.zero_problem();
  require_one_parameter(problem);
  const Eigen::Index unknowns = problem.unknowns(), equations = problem.orbit_unknowns();
  const double scale = problem.state_scale(start);
  const auto g = [&](BranchProblem& of, const Vector& u) { return scalar(of.branch_point(u, 0.0)); };
  Vector F(unknowns), row;
  double last_step = 0.0, g_scale = 1.0;
  const auto linearise = [&](const Vector& u) -> std::optional<NewtonIterate> {
    Matrix A(unknowns, unknowns);
    const double g_here = g(problem, u);
    g_scale = 1.0;
    for (Eigen::Index i = 0; i < unknowns; ++i) {
      const double h = difference_step * problem.size_of_unknown(u, i);
      const double g_ahead = g(problem, u + h * Vector::Unit(unknowns, i)),
                   g_behind = g(problem, u - h * Vector::Unit(unknowns, i));
      A(equations, i) = (g_ahead - g_behind) / (2.0 * h);
      g_scale = std::max(g_scale, std::abs(A(equations, i)) * (i < equations ? scale : problem.unit() * scale));
    }
    Vector residual;
    Matrix jacobian;
    if (!zero.evaluate(u, residual, &jacobian)) return std::nullopt;
    A.topRows(equations) = jacobian;
    F << residual, g_here;
    const OrbitLU<Matrix> lu(A);
    NewtonIterate at;
    at.residual = std::max(residual.lpNorm<Eigen::Infinity>() / scale, std::abs(g_here) / g_scale);
    at.step = lu.solve(-F);
    at.length = problem.largest_change(at.step) / scale;
    row = lu.solve_adjoint(Vector::Unit(unknowns, equations));
    last_step = at.step[equations];
    return at;
  };
  LocatedPoint located;
  located.u = start;
  located.newton = newton_to_rounding(located.u, linearise, {.acceptance = 1e-10, .shortest = 1e-13});
  if (!located.newton.converged()) return located;
  const double noise = scale * row.head(equations).lpNorm<1>() + g_scale * std::abs(row[equations]);
  const double by_steps = error_of_steps(problem, row, F, [&](BranchProblem& finer) -> Vector {
    Vector there(unknowns), residual;
    if (!finer.zero_problem().evaluate(located.u, residual, nullptr)) return {};
    there << residual, g(finer, located.u);
    return there;
  });
  located.precision = std::max(rounding_of_equations * noise + std::abs(last_step), by_steps);
  return located;
}

}  // namespace

TestFunction zero_test(std::string name, const Scalar& scalar) {
  TestFunction test;
  test.type = PointType::UZ;
  test.summary = "a scalar given by the user is zero: " + name;
  test.value = [scalar](const TestPoint& point) { return scalar(point.branch); };
  test.confirm = [](const TestPoint&, const TestPoint&) { return true; };
  test.distance = [](const BranchPoint&) { return std::numeric_limits<double>::infinity(); };
  test.locate = [scalar](BranchProblem& problem, const Vector& u, const TestPoint&) { return locate_zero(problem, u, scalar); };
  test.condition = std::move(name);
  return test;
}

}  // namespace graze
