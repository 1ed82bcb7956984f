// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's method to the last digit, and with halved steps, on equations of one unknown.
#include <graze/lib/numerics/newton.hpp>

#include <catch2/catch.hpp>

#include <cmath>
#include <optional>
#include <utility>

using namespace graze;

namespace {

/// One step on f(v) = 0.
NewtonIterate step_on(double v, double f, double slope) {
  NewtonIterate at{.residual = std::abs(f), .step = Vector{{-f / slope}}};
  at.length = std::abs(at.step[0]) / (1.0 + std::abs(v));
  return at;
}

}  // namespace

TEST_CASE("Newton's method ends at the root, when its steps are rounding") {
  Vector v{{1.0}};
  const NewtonReport report =
      newton_to_rounding(v, [](const Vector& at) { return std::optional(step_on(at[0], at[0] * at[0] - 2.0, 2.0 * at[0])); });
  CHECK(report.converged());
  CHECK(std::abs(v[0] - std::sqrt(2.0)) <= 4e-16);
  CHECK(report.iterations() <= 6);
  // With differences for a derivative it converges linearly, and ends no earlier.
  v[0] = 1.0;
  const NewtonReport slow = newton_to_rounding(
      v, [](const Vector& at) { return std::optional(step_on(at[0], at[0] * at[0] - 2.0, 1.1 * 2.0 * at[0])); });
  CHECK(slow.converged());
  CHECK(std::abs(v[0] - std::sqrt(2.0)) <= NewtonRule{}.shortest * (1.0 + std::sqrt(2.0)));  // the step that is not taken
}

TEST_CASE("Newton's method says why it ends elsewhere") {
  Vector v{{1.0}};
  const auto status = [&](double start, const NewtonRule& rule, const auto& linearise) {
    v[0] = start;
    return newton_to_rounding(v, linearise, rule).status;
  };
  const auto cosine = [](const Vector& at) { return std::optional(step_on(at[0], 2.0 + std::cos(at[0]), -std::sin(at[0]))); };
  CHECK(status(1.0, {}, cosine) == NewtonStatus::iteration_limit);  // it has no root
  CHECK(status(0.01, {.longest = 1.0}, cosine) == NewtonStatus::stalled);
  CHECK(status(0.0, {}, cosine) == NewtonStatus::singular);
  CHECK(status(0.0, {}, [](const Vector&) { return std::optional<NewtonIterate>(); }) == NewtonStatus::evaluation_failed);
  // An iterate that may not be the last one is not, however small its step.
  int evaluations = 0;
  const auto waits = [&](const Vector& at) {
    NewtonIterate one = step_on(at[0], at[0], 1.0);
    one.may_be_last = ++evaluations > 5;
    return std::optional(one);
  };
  CHECK(status(1.0, {}, waits) == NewtonStatus::converged);
  CHECK(evaluations == 6);
}

namespace {

struct DampedRun {
  NewtonReport report;
  double v;
};

/// Damped Newton steps on f(v) = 0; f returns nothing where it cannot be evaluated.
template <class F> DampedRun damped(double v, const F& f, const DampedNewtonRule& rule = {}) {
  DampedNewton newton(rule);
  double trial = v, step = 0.0;
  while (newton.open()) {
    const std::optional<std::pair<double, double>> at = f(trial);
    if (newton.take(at ? std::optional(std::abs(at->first)) : std::nullopt)) {
      v = trial;
      if (!newton.open()) break;
      step = -at->first / at->second;
      newton.begin_step(std::abs(step), 1.0 + std::abs(v));
    }
    trial = v + newton.factor() * step;
  }
  return {newton.report(), v};
}

using Value = std::optional<std::pair<double, double>>;

}  // namespace

TEST_CASE("damped Newton reaches a root from where full steps lead away") {
  const auto arctangent = [](double v) { return Value({std::atan(v), 1.0 / (1.0 + v * v)}); };
  const DampedRun run = damped(20.0, arctangent, {.max_step = 1e3});
  CHECK(run.report.converged());
  CHECK(std::abs(run.v) < 1e-12);
  const auto& history = run.report.residual_history;
  for (std::size_t k = 1; k < history.size(); ++k) CHECK(history[k] <= history[k - 1]);
  CHECK(damped(20.0, arctangent, {.max_halvings = 0, .max_step = 1e3}).report.status == NewtonStatus::stalled);
  // A bound on the step serves as well.
  CHECK(damped(20.0, arctangent, {.max_halvings = 0, .max_step = 0.5}).report.converged());
}

TEST_CASE("damped Newton halves a step beyond which the equations cannot be evaluated") {
  const auto logarithm = [](double v) { return v > 0.0 ? Value({std::log(v), 1.0 / v}) : Value(); };
  const DampedRun run = damped(10.0, logarithm, {.max_step = 10.0});
  CHECK(run.report.converged());
  CHECK(std::abs(run.v - 1.0) < 1e-12);
  CHECK(damped(-1.0, logarithm).report.status == NewtonStatus::evaluation_failed);
}

TEST_CASE("damped Newton ends at rounding, and says why it ends elsewhere") {
  const auto parabola = [](double v) { return Value({v * v - 2.0, 2.0 * v}); };
  const DampedRun run = damped(1.0, parabola);
  CHECK(run.report.converged());
  CHECK(std::abs(run.v - std::sqrt(2.0)) < 1e-15);
  CHECK(run.report.iterations() <= 8);
  CHECK(damped(1.0, parabola, {.max_iterations = 2}).report.status == NewtonStatus::iteration_limit);
  CHECK(damped(0.0, parabola).report.status == NewtonStatus::singular);
  CHECK(damped(0.7, [](double v) { return Value({1.0 + v * v, 2.0 * v}); }).report.status == NewtonStatus::stalled);
  // A member of a family: the derivative is rounding, the residual too.
  const DampedRun family = damped(3.0, [](double) { return Value({1e-17, 1e-16}); });
  CHECK(family.report.converged());
  CHECK(family.v == 3.0);
}
