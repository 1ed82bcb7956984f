// SPDX-License-Identifier: GPL-3.0-or-later
// Kinks of a branch: its orbits touch a surface, along which they begin or cease to slide or stick. No impact is gained or lost,
// but other events come or go, and the multipliers jump. The orbits go on, or turn in the parameter.
#pragma once

#include <graze/continuation/problems/orbit_problem.hpp>
#include <graze/continuation/trace/trace.hpp>

#include <functional>
#include <optional>

namespace graze {

/// Whether the multipliers jump between two orbits of a branch with the same impacts and other events.
bool is_kink(const BranchPoint& before, const BranchPoint& after);

/// Whether friction holds a body all along the orbit u whose place is not pinned.
bool holds_more(const OrbitProblem& problem, const Vector& u);
/// Whether a pinned state no longer keeps its value at this point: its closing equation is a condition again.
bool releases_pinned(const OrbitProblem& problem, const BranchPoint& point);

/// Sets value, bracket and scenario of the kink between the last point of the branch and `next`. `holds`: friction holds more
/// beyond it. The branch may then have followed the edge of the band of places first, on which a multiplier is 1.
void describe_kink(SpecialPoint& kink, const Branch& branch, const BranchPoint& next, bool holds, bool goes_on);

/// The first orbit beyond a kink next to `last`, the end of the branch so far.
struct BeyondKink {
  CurvePoint curve;
  BranchPoint point;
  bool goes_on = true;  ///< in the same direction of the parameter
};
/// Empty: there is none whose tangent leads to `last`, or it was cancelled.
std::optional<BeyondKink> beyond_kink(OrbitProblem& problem, const CurvePoint& last, const BranchPoint& end,
                                      const TraceOptions& options, const std::function<bool()>& cancelled);

}  // namespace graze
