// SPDX-License-Identifier: GPL-3.0-or-later
// TestFunction: the door where a new bifurcation enters: a scalar along a branch whose sign change announces a special point, a
// confirmation, and the extended system by which the point is located.
//
// To add one: a file in this folder that makes a TestFunction, and one line in test_functions().
#pragma once

#include <graze/continuation/conditions/multiplier_condition.hpp>
#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/trace/trace.hpp>

#include <vector>

namespace graze {

/// What a test function may look at: a point of the curve with its multipliers.
struct TestPoint {
  const CurvePoint& curve;
  const BranchPoint& branch;
};

struct TestFunction {
  PointType type = PointType::MX;
  const char* summary = "";
  /// The scalar; its sign change announces the point.
  double (*value)(const TestPoint& point) = nullptr;
  /// After a sign change: is it this bifurcation?
  bool (*confirm)(const TestPoint& before, const TestPoint& after) = nullptr;
  /// If that is denied: may the points be too far apart to tell? May be empty: never.
  bool (*too_far_apart)(const TestPoint& before, const TestPoint& after) = nullptr;
  /// How far the multipliers are from those that the bifurcation has.
  double (*distance)(const BranchPoint& point) = nullptr;
  /// Newton on the extended system from u, in the branch's own coordinates; `near` is a point close by.
  LocatedPoint (*locate)(BranchProblem& problem, const Vector& u, const TestPoint& near) = nullptr;
  /// Adds details to the located point; may be empty.
  void (*describe)(BranchProblem& problem, const LocatedPoint& located, SpecialPoint& point) = nullptr;
};

TestFunction fold_test();
TestFunction period_doubling_test();
TestFunction branch_point_test();
TestFunction neimark_sacker_test();

/// All test functions, in the order in which they are evaluated.
const std::vector<TestFunction>& test_functions();

/// Whether the parameter stands still, but for rounding: the branch is a family of orbits at one value (of a conservative
/// system), each with a multiplier +1, on which neither a fold nor a branch point is to be seen.
bool stands_still(const TestPoint& before, const TestPoint& after);

/// Nontrivial multipliers of a point.
std::vector<std::complex<double>> nontrivial(const FloquetMultipliers& multipliers);

/// Distance of the nontrivial multiplier that is nearest to `mu`.
double nearest_multiplier(const BranchPoint& point, double mu);

/// Number of real nontrivial multipliers above +1 (unit = 1) or below -1 (unit = -1). Whether it is odd is the sign of
/// det(M - I), of det(M + I): complex pairs do not change them.
int real_beyond(const TestPoint& point, int unit);

}  // namespace graze
