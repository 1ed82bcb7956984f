// SPDX-License-Identifier: GPL-3.0-or-later
// TestFunction: the definition of one type of bifurcation: a scalar along a branch whose sign change announces a special point,
// a confirmation, the equations that define the point, and the branch that is born there.
//
// To add a bifurcation, write a file in this folder that makes a TestFunction, and add one line to test_functions(). A program
// that uses the library passes its own in ContinuationOptions::further_tests, with the type UZ and a name. zero_test() makes one
// from a scalar of the orbit. multiplier_equations() defines the points at which a multiplier has a value. The functions are
// called from several threads if several branches are followed in parallel.
#pragma once

#include <graze/continuation/conditions/birth.hpp>
#include <graze/continuation/conditions/defining_equations.hpp>
#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/trace/trace.hpp>

#include <complex>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace graze {

/// Input of a test function: a point of the curve with its multipliers.
struct TestPoint {
  const CurvePoint& curve;
  const BranchPoint& branch;
  double unit = 1.0;  ///< of the parameter (parameter_unit)

  /// Rate of the parameter along the curve, in its unit by the arclength: a branch has one free parameter, the last unknown.
  double parameter_rate() const { return curve.tangent[curve.tangent.size() - 1] / unit; }
};

struct TestFunction {
  PointType type = PointType::MX;
  std::string summary;  ///< one line: name, and the condition
  /// Of a condition from outside the library: its name. Its points get this name as their detail "condition".
  std::string condition = {};
  /// The scalar (dimensionless). Its sign change announces the point.
  std::function<double(const TestPoint& point)> value;
  /// After a sign change between two points: whether it is this bifurcation.
  std::function<bool(const TestPoint& before, const TestPoint& after)> confirm;
  /// If `confirm` returns false: whether the points may be too far apart to decide. Empty: never.
  std::function<bool(const TestPoint& before, const TestPoint& after)> too_far_apart = {};
  /// Distance of the multipliers from those at the bifurcation; infinity if there are none to compare.
  std::function<double(const BranchPoint& point)> distance;
  /// The equations that define the point, with first guesses from a neighbouring point; locate() solves them in the branch's own
  /// coordinates. If it does not converge, the sign change is bracketed along the branch, and the point is kept if `distance` is
  /// small there.
  std::function<std::unique_ptr<DefiningEquations>(const TestPoint& near)> equations;
  /// Adds details to the located point. Empty: none.
  std::function<void(BranchProblem& problem, const LocatedPoint& located, SpecialPoint& point)> describe = {};
  std::optional<Birth> born = {};  ///< the branch that is born there; none: no branch is
};

TestFunction fold_test();
TestFunction period_doubling_test();
TestFunction branch_point_test();
TestFunction neimark_sacker_test();

/// Points at which a scalar of the orbit is zero: a condition from outside the library, for example a state at phase 0 minus a
/// bound. They have the type UZ, and `name` as their detail "condition". The scalar must be smooth along the branch.
TestFunction zero_test(std::string name, const std::function<double(const BranchPoint& point)>& scalar);

/// All test functions of bifurcations, in the order in which they are evaluated.
const std::vector<TestFunction>& test_functions();

/// The branch that is born at the point by test_functions() or one of `further`; null if none is.
const Birth* born_at(const SpecialPoint& point, const std::vector<TestFunction>& further);

/// Whether the parameter is constant to rounding between two points. The branch is then a family of orbits of a conservative
/// system at one parameter value. Each orbit has a multiplier +1, and the test functions of folds and branch points are
/// meaningless.
bool stands_still(const TestPoint& before, const TestPoint& after);

/// The nontrivial multipliers: all but the last `multipliers.trivial` ones.
std::vector<std::complex<double>> nontrivial(const FloquetMultipliers& multipliers);

/// Smallest distance of a nontrivial multiplier from `mu`; infinity if there is none.
double nearest_multiplier(const BranchPoint& point, double mu);

/// Number of real nontrivial multipliers above +1 (unit = 1) or below -1 (unit = -1). Its parity gives the sign of det(M - I)
/// or det(M + I), because complex pairs do not change these signs.
int real_beyond(const TestPoint& point, int unit);

}  // namespace graze
