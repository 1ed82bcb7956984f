// SPDX-License-Identifier: GPL-3.0-or-later
// Kinks of a branch: its orbits touch a surface. There they begin or cease to slide or stick, or a stop with a damper that has
// let go is met again before the motion has left it. No impact is gained or lost, but other events come or go, and the
// multipliers jump. The orbits go on, or turn in the parameter.
#pragma once

#include <graze/continuation/branch/points_in_step.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>
#include <graze/continuation/trace/trace.hpp>

#include <functional>
#include <optional>

namespace graze {

/// Whether the multipliers jump between two orbits of a branch with the same impacts and other events, by more than `jump`
/// relative to 1 + |mu|. In a long step they may change by much without a kink; next to one, little does.
inline constexpr double sure_jump = 0.1, least_jump = 0.01;
bool is_kink(const BranchPoint& before, const BranchPoint& after, double jump = sure_jump);

/// Whether friction holds a body all along the orbit u whose place is not pinned.
bool holds_more(const OrbitProblem& problem, const Vector& u);
/// Whether a pinned state no longer keeps its value at this point: its closing equation is a condition again.
bool releases_pinned(const OrbitProblem& problem, const BranchPoint& point);

/// The kink between two orbits next to it; its kind is "sliding" or, if only stops take part in it, "contact".
SpecialPoint kink_between(OrbitProblem& problem, const PointBetween& before, const PointBetween& after, const Branch& branch,
                          bool goes_on);
/// The last point of the branch before friction holds a body all along. The branch may have followed the edge of the band of
/// places first, on which a multiplier is 1.
std::size_t last_before_hold(const Branch& branch);

/// A kink within a step in which the multipliers jump by less than sure_jump: the step is halved down to it.
std::optional<PointInStep> kink_in_step(OrbitProblem& problem, const TestPoint& before, const TestPoint& after,
                                        const Branch& branch, const TraceOptions& options);

/// The first orbit beyond a kink next to `last`, the end of the branch so far.
struct BeyondKink {
  CurvePoint curve;
  BranchPoint point;
  bool goes_on = true;  ///< in the same direction of the parameter
};
/// Empty: there is none whose tangent leads to `last` but those of the branch itself, or it was cancelled.
std::optional<BeyondKink> beyond_kink(OrbitProblem& problem, const CurvePoint& last, const BranchPoint& end,
                                      const TraceOptions& options, const std::function<bool()>& cancelled);

}  // namespace graze
