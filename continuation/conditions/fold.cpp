// SPDX-License-Identifier: GPL-3.0-or-later
// LP, fold (limit point): the branch turns in the parameter, and a multiplier passes +1.
//
// Test function: the parameter's component of the tangent. It also passes zero on the branch that turns in a pitchfork. There a
// multiplier only touches +1, and the point is a branch point.
#include <graze/continuation/conditions/multiplier_equations.hpp>
#include <graze/continuation/conditions/test_function.hpp>

namespace graze {

TestFunction fold_test() {
  TestFunction test;
  test.type = PointType::LP;
  test.summary = "fold: the parameter's component of the tangent passes zero (a multiplier passes +1)";
  test.value = [](const TestPoint& point) { return point.parameter_rate(); };
  test.confirm = [](const TestPoint& before, const TestPoint& after) {
    return !stands_still(before, after) && (real_beyond(before, 1) + real_beyond(after, 1)) % 2 == 1;
  };
  test.distance = [](const BranchPoint& point) { return nearest_multiplier(point, 1.0); };
  test.equations = [](const TestPoint&) { return multiplier_equations({.theta = 0.0}); };
  return test;
}

}  // namespace graze
