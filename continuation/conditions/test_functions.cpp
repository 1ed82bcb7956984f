// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/test_function.hpp>

#include <limits>
#include <string>
#include <variant>

namespace graze {

const std::vector<TestFunction>& test_functions() {
  static const std::vector<TestFunction> list = {fold_test(), period_doubling_test(), branch_point_test(), neimark_sacker_test()};
  return list;
}

const Birth* born_at(const SpecialPoint& point, const std::vector<TestFunction>& further) {
  const auto detail = point.details.find("condition");
  const std::string* const name = detail == point.details.end() ? nullptr : std::get_if<std::string>(&detail->second);
  for (const std::vector<TestFunction>* list : {&test_functions(), &further})
    for (const TestFunction& test : *list)
      if (test.type == point.type && test.condition == (name ? *name : "")) return test.born ? &*test.born : nullptr;
  return nullptr;
}

bool stands_still(const TestPoint& before, const TestPoint& after) {
  // If a fold lay this close to both points, the value would change by about the square of the step.
  constexpr double tangent = 1e-9, least_step = 1e-6, rounding = 1e-14;
  const auto still = [](const TestPoint& point) { return std::abs(point.parameter_rate()) < tangent; };
  const double change = std::abs(after.branch.value - before.branch.value);
  return still(before) && still(after) && std::abs(after.curve.arclength - before.curve.arclength) > least_step &&
         change <= rounding * (before.unit + std::abs(before.branch.value));
}

std::vector<std::complex<double>> nontrivial(const FloquetMultipliers& multipliers) {
  return {multipliers.values.begin(),
          multipliers.values.end() - std::min<std::ptrdiff_t>(multipliers.trivial, std::ssize(multipliers.values))};
}

double nearest_multiplier(const BranchPoint& point, double mu) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& value : nontrivial(point.multipliers)) least = std::min(least, std::abs(value - mu));
  return least;
}

int real_beyond(const TestPoint& point, int unit) {
  int count = 0;
  for (const auto& mu : nontrivial(point.branch.multipliers)) count += mu.imag() == 0.0 && unit * mu.real() > 1.0 ? 1 : 0;
  return count;
}

}  // namespace graze
