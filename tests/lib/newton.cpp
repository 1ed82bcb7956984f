// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's method to the last digit, to a tolerance, and with halved steps, on equations of one unknown.
#include <graze/lib/tasks/newton_loop.hpp>

#include <catch2/catch.hpp>

#include <cmath>
#include <optional>
#include <utility>

using namespace graze;

namespace {

using Value = std::optional<std::pair<double, double>>;

struct Run {
  NewtonReport report;
  double v;
};

/// Newton's method on f(v) = 0; f returns the value and the slope, or nothing where it cannot be evaluated.
template <class F> Run run(double start, const F& f, const NewtonRule& rule = {}, int steps_before_the_last = 0) {
  Vector v{{start}};
  Value at;
  int steps = 0;
  const auto residual = [&](const Vector& trial) -> std::optional<double> {
    at = f(trial[0]);
    return at ? std::optional(std::abs(at->first)) : std::nullopt;
  };
  const auto solve = [&](const Vector& u, Vector& step) -> NewtonStep {
    step = Vector{{-at->first / at->second}};
    return {.length = std::abs(step[0]), .size = 1.0 + std::abs(u[0]), .may_be_last = ++steps > steps_before_the_last};
  };
  const NewtonReport report = newton(v, residual, solve, rule);
  return {report, v[0]};
}

Value parabola(double v) { return Value({v * v - 2.0, 2.0 * v}); }

}  // namespace

TEST_CASE("Newton's method ends at the root, when its steps are rounding") {
  const Run quick = run(1.0, parabola, newton_to_rounding());
  CHECK(quick.report.converged());
  CHECK(std::abs(quick.v - std::sqrt(2.0)) <= 4e-16);
  CHECK(quick.report.iterations() <= 6);
  // With a wrong slope it converges linearly, and ends no earlier.
  const auto wrong_slope = [](double v) { return Value({v * v - 2.0, 1.1 * 2.0 * v}); };
  const Run slow = run(1.0, wrong_slope, newton_to_rounding());
  CHECK(slow.report.converged());
  CHECK(std::abs(slow.v - std::sqrt(2.0)) <= 1e-14 * (1.0 + std::sqrt(2.0)));  // the step that is not taken
  // A small residual is not enough.
  NewtonRule few = newton_to_rounding(1.0);
  few.max_iterations = 3;
  CHECK(run(1.0, wrong_slope, few).report.status == NewtonStatus::iteration_limit);
}

TEST_CASE("Newton's method says why it ends elsewhere") {
  const auto cosine = [](double v) { return Value({2.0 + std::cos(v), -std::sin(v)}); };  // it has no root
  NewtonRule near = newton_to_rounding();
  near.longest = 1.0;
  CHECK(run(1.0, cosine, newton_to_rounding()).report.status == NewtonStatus::iteration_limit);
  CHECK(run(0.01, cosine, near).report.status == NewtonStatus::stalled);
  CHECK(run(0.0, cosine, newton_to_rounding()).report.status == NewtonStatus::singular);
  const auto nowhere = [](double) { return Value(); };
  CHECK(run(0.0, nowhere, newton_to_rounding()).report.status == NewtonStatus::evaluation_failed);
  const auto root = [](double v) { return v >= 0.0 ? Value({std::sqrt(v) + 1.0, 0.5 / std::sqrt(v)}) : Value(); };
  CHECK(run(1.0, root, newton_to_rounding()).report.status == NewtonStatus::evaluation_failed);  // after the first step
  // An iterate that may not be the last one is not, however small its step.
  const auto line = [](double v) { return Value({v, 1.0}); };
  CHECK(run(1.0, line, newton_to_rounding()).report.iterations() == 1);
  const Run waits = run(1.0, line, newton_to_rounding(), 5);
  CHECK(waits.report.converged());
  CHECK(waits.report.iterations() == 5);
}

TEST_CASE("Newton's method ends at the first residual that is small enough, and not before a step") {
  const NewtonRule rule{.acceptance = 1e-8, .tolerance = 1e-8, .rounding = 1e-3, .growth = 10.0, .max_halvings = 0};
  const Run early = run(1.5, parabola, rule);
  CHECK(early.report.status == NewtonStatus::stalled);  // 1e-3 is not accepted
  CHECK(early.report.iterations() == 2);
  const Run at_root = run(std::sqrt(2.0), parabola, rule);
  CHECK(at_root.report.converged());
  CHECK(at_root.report.iterations() == 1);
  // An isolated solution is not found where the Jacobian is singular.
  NewtonRule isolated = rule;
  isolated.isolated = true;
  const auto flat = [](double) { return Value({1e-17, 1e-20}); };
  CHECK(run(3.0, flat, rule).report.converged());
  CHECK(run(
            3.0,
            [](double v) {
              return v < 4.0 ? Value({1e-17, -1e-20}) : Value();
            },
            isolated)
            .report.status == NewtonStatus::evaluation_failed);
  CHECK(run(
            3.0,
            [](double) {
              return Value({1e-17, 0.0});
            },
            isolated)
            .report.status == NewtonStatus::singular);
  // A residual may grow, but not tenfold.
  const auto bump = [](double v) { return Value({v > 0.5 ? 1.0 : v > -0.5 ? 5.0 : 100.0, 1.0}); };
  const Run grows = run(1.0, bump, rule);
  CHECK(grows.report.status == NewtonStatus::stalled);
  CHECK(grows.report.residual() == 5.0);
}

TEST_CASE("damped Newton reaches a root from where full steps lead away") {
  const auto arctangent = [](double v) { return Value({std::atan(v), 1.0 / (1.0 + v * v)}); };
  const Run reached = run(20.0, arctangent, {.max_step = 1e3});
  CHECK(reached.report.converged());
  CHECK(std::abs(reached.v) < 1e-12);
  const auto& history = reached.report.residual_history;
  for (std::size_t k = 1; k < history.size(); ++k) CHECK(history[k] <= history[k - 1]);
  CHECK(run(20.0, arctangent, {.max_halvings = 0, .max_step = 1e3}).report.status == NewtonStatus::stalled);
  // A bound on the step serves as well.
  CHECK(run(20.0, arctangent, {.max_halvings = 0, .max_step = 0.5}).report.converged());
}

TEST_CASE("damped Newton halves a step beyond which the equations cannot be evaluated") {
  const auto logarithm = [](double v) { return v > 0.0 ? Value({std::log(v), 1.0 / v}) : Value(); };
  const Run reached = run(10.0, logarithm, {.max_step = 10.0});
  CHECK(reached.report.converged());
  CHECK(std::abs(reached.v - 1.0) < 1e-12);
  CHECK(run(-1.0, logarithm).report.status == NewtonStatus::evaluation_failed);
}

TEST_CASE("damped Newton ends at rounding, and says why it ends elsewhere") {
  const Run reached = run(1.0, parabola);
  CHECK(reached.report.converged());
  CHECK(std::abs(reached.v - std::sqrt(2.0)) < 1e-15);
  CHECK(reached.report.iterations() <= 8);
  CHECK(run(1.0, parabola, {.max_iterations = 2}).report.status == NewtonStatus::iteration_limit);
  CHECK(run(0.0, parabola).report.status == NewtonStatus::singular);
  CHECK(run(0.7, [](double v) { return Value({1.0 + v * v, 2.0 * v}); }).report.status == NewtonStatus::stalled);
  // A member of a family: the derivative is rounding, the residual too.
  const Run family = run(3.0, [](double) { return Value({1e-17, 1e-16}); });
  CHECK(family.report.converged());
  CHECK(family.v == 3.0);
}
