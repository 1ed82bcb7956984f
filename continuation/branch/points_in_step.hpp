// SPDX-License-Identifier: GPL-3.0-or-later
// Special points within a step of a branch, located between the two points that the step joins: by Newton's method on the
// condition of the bifurcation or, where that fails, by the sign change along the branch.
#pragma once

#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

#include <optional>
#include <vector>

namespace graze {

/// A special point within a step: `place` along the step orders it among the others, `u` is the orbit there.
struct PointInStep {
  double place = 0.0;
  Vector u;
  SpecialPoint point;
};

/// A point of the curve between two others, and its multipliers.
struct PointBetween {
  CurvePoint curve;
  BranchPoint branch;
};
/// The point of the branch at this part of the step; empty if the corrector fails or its multipliers do not exist.
std::optional<PointBetween> point_between(BranchProblem& problem, const TestPoint& before, const TestPoint& after, double part,
                                          const TraceOptions& options);

/// The place of u along the step from `before`, in arclength.
double place_of(const ZeroProblem& zero, const CurvePoint& before, const Vector& u);

/// The orbit of the branch near u at this value of the parameter; empty if the corrector fails.
Vector at_value(BranchProblem& problem, Vector u, double value, const TraceOptions& options);

/// The special point of an orbit that needs no location: an end, a requested value.
SpecialPoint plain_point(BranchProblem& problem, const Vector& u, PointType type, const Branch& branch);

/// True if the multipliers coincide with those of the bifurcation to rounding at both ends of the step: then they cross in
/// rounding alone. This occurs where a doubled branch begins, and along orbits of a conservative resonance, which all have
/// these multipliers. Two coinciding multipliers are known only to the square root of rounding.
bool in_rounding(const TestFunction& test, const TestPoint& a, const TestPoint& b);

/// A sign change before it is located. `halve`: its ends are too far apart to confirm it; the step is halved
/// until they are not. `at_corner`: it lies at the corner of a stiff contact, where any sign change is the point.
struct SignChange {
  bool halve = false;
  bool at_corner = false;
};
/// Locates the sign change of a test function. Empty if it is none of a special point of this type.
std::optional<PointInStep> locate_in_step(BranchProblem& problem, const TestFunction& test, const TestPoint& before,
                                          const TestPoint& after, SignChange change, const Branch& branch,
                                          const TraceOptions& options);

/// Adds a point UZ for each of these values that the step passes, on both sides of a fold in `met`.
void add_user_points(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, const std::vector<double>& values,
                     const TraceOptions& options, const Branch& branch, std::vector<PointInStep>& met);

}  // namespace graze
