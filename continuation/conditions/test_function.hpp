// SPDX-License-Identifier: GPL-3.0-or-later
// TestFunction: the definition of one type of bifurcation: a scalar along a branch whose sign change announces a special point,
// a confirmation, and the extended system that locates the point.
//
// To add a bifurcation, write a file in this folder that makes a TestFunction, and add one line to test_functions().
#pragma once

#include <graze/continuation/conditions/multiplier_condition.hpp>
#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/trace/trace.hpp>

#include <vector>

namespace graze {

/// Input of a test function: a point of the curve with its multipliers.
struct TestPoint {
  const CurvePoint& curve;
  const BranchPoint& branch;
};

struct TestFunction {
  PointType type = PointType::MX;
  const char* summary = "";  ///< one line: name, and the condition
  /// The scalar (dimensionless). Its sign change announces the point.
  double (*value)(const TestPoint& point) = nullptr;
  /// After a sign change between two points: whether it is this bifurcation.
  bool (*confirm)(const TestPoint& before, const TestPoint& after) = nullptr;
  /// If `confirm` returns false: whether the points may be too far apart to decide. Null: never.
  bool (*too_far_apart)(const TestPoint& before, const TestPoint& after) = nullptr;
  /// Distance of the multipliers from those at the bifurcation; infinity if there are none to compare.
  double (*distance)(const BranchPoint& point) = nullptr;
  /// Newton's method on the extended system from u, in the branch's own coordinates. `near` is a neighbouring point.
  LocatedPoint (*locate)(BranchProblem& problem, const Vector& u, const TestPoint& near) = nullptr;
  /// Adds details to the located point. Null: none.
  void (*describe)(BranchProblem& problem, const LocatedPoint& located, SpecialPoint& point) = nullptr;
};

TestFunction fold_test();
TestFunction period_doubling_test();
TestFunction branch_point_test();
TestFunction neimark_sacker_test();

/// All test functions, in the order in which they are evaluated.
const std::vector<TestFunction>& test_functions();

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
