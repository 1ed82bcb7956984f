// SPDX-License-Identifier: GPL-3.0-or-later
// LP: the branch turns in the parameter; a multiplier passes +1. Test: the parameter's component of the tangent.
#include <graze/continuation/test_functions/test_function.hpp>

namespace graze {

TestFunction fold_test() {
  TestFunction test;
  test.type = PointType::LP;
  test.summary = "fold: the parameter's component of the tangent passes zero (a multiplier passes +1)";
  test.value = [](const TestPoint& point) { return point.curve.tangent[point.curve.tangent.size() - 1]; };
  test.confirm = [](const TestPoint&, const TestPoint&) { return true; };
  test.locate = [](OrbitProblem& problem, const Vector& u, const TestPoint&) {
    return locate_multiplier(problem, u, {.theta = 0.0});
  };
  return test;
}

}  // namespace graze
