// SPDX-License-Identifier: GPL-3.0-or-later
// PD: a multiplier passes -1. Test: the product of (1 + mu) over all multipliers.
//
// Criticality from the normal form xi -> -xi + c xi^3 on the centre manifold (Kuznetsov, Elements of Applied Bifurcation Theory,
// 3rd ed., eq. (5.46)-(5.47)): with M q = -q, M^T p = -p, p.q = 1,
//     c = p . [C(q, q, q) + 3 B(q, (I - M)^{-1} B(q, q))] / 6;   c > 0: supercritical, c < 0: subcritical.
// B and C come from central differences of the (exact) Jacobian of the period-n map along q.
#include <graze/continuation/null_vectors.hpp>
#include <graze/continuation/test_functions/test_function.hpp>

#include <cmath>
#include <numbers>
#include <optional>

namespace graze {

namespace {

struct NormalForm {
  double c = 0.0;
  double error = 0.0;  ///< how far halving the difference step moved c
};

std::optional<NormalForm> normal_form(OrbitProblem& problem, const LocatedPoint& located) {
  const int n = problem.states();
  ShootingEquations& equations = problem.equations();
  const double duration = equations.duration(located.u.head(located.u.size() - 1));
  const double start = equations.node_time(located.u.head(located.u.size() - 1), 0);
  const Vector x0 = located.u.head(n);
  Transition transition;
  std::vector<std::size_t> sequence;
  const auto jacobian = [&](const Vector& x) -> std::optional<Matrix> {
    carry(equations.propagator(), start, start + duration, x, {.sensitivity = Sensitivity::state}, transition);
    if (transition.termination != Termination::time) return std::nullopt;
    if (sequence.empty()) sequence = transition.event_sequence;
    if (transition.event_sequence != sequence) return std::nullopt;
    return transition.Phi;
  };
  const std::optional<Matrix> M = jacobian(x0);
  if (!M) return std::nullopt;
  // Left and right eigenvectors for -1: null vectors of M + I.
  const NullVectors<Matrix> null = null_vectors(Matrix(*M + Matrix::Identity(n, n)));
  const Vector& q = null.right;
  Vector p = null.left;
  p /= p.dot(q);
  const Eigen::PartialPivLU<Matrix> second_order(Matrix::Identity(n, n) - *M);
  const auto coefficient = [&](double h) -> std::optional<double> {
    const auto ahead = jacobian(x0 + h * q), behind = jacobian(x0 - h * q);
    if (!ahead || !behind) return std::nullopt;
    const Matrix along = (*ahead - *behind) / (2.0 * h);
    const Matrix second = (*ahead - 2.0 * *M + *behind) / (h * h);
    const Vector h2 = second_order.solve(along * q);
    return (p.dot(second * q) + 3.0 * p.dot(along * h2)) / 6.0;
  };
  // The step must stay within the orbit's signature, and be large against the rounding of second differences.
  for (double h = 4e-3; h > 1e-5; h *= 0.5) {
    const auto coarse = coefficient(h), fine = coefficient(h / 2);
    if (coarse && fine && std::isfinite(*coarse) && std::isfinite(*fine))
      return NormalForm{(4.0 * *fine - *coarse) / 3.0, std::abs(*fine - *coarse)};
  }
  return std::nullopt;
}

}  // namespace

TestFunction period_doubling_test() {
  TestFunction test;
  test.type = PointType::PD;
  test.summary = "period doubling: the product of (1 + multiplier) passes zero (a multiplier passes -1)";
  test.value = [](const TestPoint& point) {
    std::complex<double> product = 1.0;
    for (const auto& mu : nontrivial(point.branch.multipliers)) product *= (1.0 + mu) / (1.0 + std::abs(mu));
    return product.real();
  };
  test.confirm = [](const TestPoint& before, const TestPoint& after) {
    return (real_beyond(before, -1) + real_beyond(after, -1)) % 2 == 1;
  };
  test.locate = [](OrbitProblem& problem, const Vector& u, const TestPoint&) {
    return locate_multiplier(problem, u, {.theta = std::numbers::pi});
  };
  test.describe = [](OrbitProblem& problem, const LocatedPoint& located, SpecialPoint& point) {
    if (const auto form = normal_form(problem, located)) {
      point.details["normal_form"] = form->c;
      point.details["normal_form_error"] = form->error;
      if (std::abs(form->c) <= form->error) return;
      point.details.emplace("criticality", std::string(form->c > 0.0 ? "supercritical" : "subcritical"));
      point.details.emplace("criticality_from", std::string("normal form"));
    }
  };
  return test;
}

}  // namespace graze
