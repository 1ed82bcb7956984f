// SPDX-License-Identifier: GPL-3.0-or-later
// BP: two branches cross; a multiplier passes +1 while the branch does not turn, or (on the branch that turns in a pitchfork) the
// branch turns while a multiplier only touches +1. Test: det(M - I) with the sign of the parameter's component of the tangent,
// which keeps its sign at a fold (both change) and changes it at a branch point: the sign of the determinant of the equations'
// Jacobian bordered by the tangent.
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
    const double aligning_periods = point.curve.tangent[point.curve.tangent.size() - 1];
    return std::copysign(product.real(), product.real() * aligning_periods);
  };
  test.confirm = [](const TestPoint& before, const TestPoint& after) {
    if (stands_still(before, after)) return false;
    const auto aligning_periods = [](const TestPoint& point) {
      return point.curve.tangent[point.curve.tangent.size() - 1] > 0.0;
    };
    const bool passes = (real_beyond(before, 1) + real_beyond(after, 1)) % 2 == 1,
               turns = aligning_periods(before) != aligning_periods(after);
    return passes != turns;
  };
  test.distance = [](const BranchPoint& point) { return nearest_multiplier(point, 1.0); };
  test.locate = [](BranchProblem& problem, const Vector& u, const TestPoint&) { return locate_branch_point(problem, u); };
  return test;
}

}  // namespace graze
