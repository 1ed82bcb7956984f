// SPDX-License-Identifier: GPL-3.0-or-later
// BP, branch point: two branches cross. Either a multiplier passes +1 and the branch does not turn, or the branch turns and a
// multiplier only touches +1 (the branch that turns in a pitchfork).
//
// Test function: det(M - I) times the sign of the parameter's component of the tangent. At a fold both factors change sign, so
// that the product keeps its sign. At a branch point the product changes its sign. This is the sign of the determinant of the
// equations' Jacobian bordered by the tangent.
#include <graze/continuation/conditions/test_function.hpp>

#include <graze/continuation/conditions/branch_point_condition.hpp>

#include <cmath>

namespace graze {

TestFunction branch_point_test() {
  TestFunction test;
  test.type = PointType::BP;
  test.summary = "branch point: the product of (multiplier - 1) passes zero, or the branch turns, but not both";
  test.value = [](const TestPoint& point) {
    std::complex<double> product = 1.0;
    for (const auto& mu : nontrivial(point.branch.multipliers)) product *= (mu - 1.0) / (1.0 + std::abs(mu));
    const double parameter_component = point.curve.tangent[point.curve.tangent.size() - 1];
    return std::copysign(product.real(), product.real() * parameter_component);
  };
  test.confirm = [](const TestPoint& before, const TestPoint& after) {
    if (stands_still(before, after)) return false;
    const auto goes_up = [](const TestPoint& point) { return point.curve.tangent[point.curve.tangent.size() - 1] > 0.0; };
    const bool passes = (real_beyond(before, 1) + real_beyond(after, 1)) % 2 == 1, turns = goes_up(before) != goes_up(after);
    return passes != turns;
  };
  test.distance = [](const BranchPoint& point) { return nearest_multiplier(point, 1.0); };
  test.locate = [](BranchProblem& problem, const Vector& u, const TestPoint&) { return locate_branch_point(problem, u); };
  return test;
}

}  // namespace graze
