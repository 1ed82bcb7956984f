// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's method to the last digit, on equations of one unknown.
#include <graze/lib/numerics/newton.hpp>

#include <catch2/catch.hpp>

#include <cmath>

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
