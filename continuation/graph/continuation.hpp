// SPDX-License-Identifier: GPL-3.0-or-later
// Continuation of periodic orbits in a parameter: the branch through an orbit, and the branches born on it.
#pragma once

#include <graze/continuation/branch/continuation_options.hpp>

namespace graze {

/// The branch through `orbit` and, for each generation, the branches born at its period doublings. Branch ids count from 1.
/// @throws std::invalid_argument for an unknown parameter, or a range outside the model's limits.
std::vector<Branch> continue_orbit(const HybridSystem& system, const PeriodicOrbit& orbit, const ContinuationOptions& options);

/// The branch through `orbit`, followed in both directions within near +- reach (extended to the orbit itself), and the
/// branches beyond its grazings.
std::vector<Branch> follow_near(const HybridSystem& system, const PeriodicOrbit& orbit, double near, double reach,
                                const ContinuationOptions& given);

/// Result of locate().
struct LocateResult {
  std::optional<SpecialPoint> point;
  std::string message;  ///< if point is empty: the special points found instead, and the reasons for ending
};

/// The special point of this type on these branches and within near +- reach whose parameter value is nearest to `near`. "Lost"
/// and "gained" of a grazing are given for a decreasing parameter.
LocateResult nearest_point(const HybridSystem& system, const std::vector<Branch>& branches, const std::string& parameter,
                           PointType type, double near, double reach);

/// The nearest point on the branches of follow_near().
LocateResult locate(const HybridSystem& system, const PeriodicOrbit& orbit, PointType type, double near, double reach,
                    const ContinuationOptions& options);

/// Checks the invariants of a branch: points satisfy the equations, arclength grows, stored stability equals the recomputed
/// one, special points lie in their interval, and the unstable count changes across them. Also detects jumps and retraced
/// parts. One sentence per violation; empty if all hold.
std::vector<std::string> check_branch(const HybridSystem& system, const Branch& branch);

}  // namespace graze
