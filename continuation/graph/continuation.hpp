// SPDX-License-Identifier: GPL-3.0-or-later
// Following periodic orbits in a parameter: the branch through an orbit, and the branches born on it.
#pragma once

#include <graze/continuation/branch/continuation_options.hpp>

namespace graze {

/// The branch through `orbit` and, generation after generation, those born at its period doublings. Branch ids count from 1.
/// @throws std::invalid_argument for a parameter the system does not have, or a range outside what the model allows.
std::vector<Branch> continue_orbit(const HybridSystem& system, const PeriodicOrbit& orbit, const ContinuationOptions& options);

/// The branch through `orbit`, followed both ways within near +- reach (and as far as the orbit itself), and the branches beyond
/// its grazings.
std::vector<Branch> follow_near(const HybridSystem& system, const PeriodicOrbit& orbit, double near, double reach,
                                const ContinuationOptions& options);

/// What locate found, or why not.
struct LocateResult {
  std::optional<SpecialPoint> point;
  std::string message;  ///< where point is empty: what was found instead
};

/// Of the special points of a type on these branches and within near +- reach, the one whose parameter value lies nearest to
/// `near`. Lost and gained are those of a grazing with the parameter decreasing.
LocateResult nearest_point(const HybridSystem& system, const std::vector<Branch>& branches, const std::string& parameter,
                           PointType type, double near, double reach);

/// The nearest point on the branches of follow_near().
LocateResult locate(const HybridSystem& system, const PeriodicOrbit& orbit, PointType type, double near, double reach,
                    const ContinuationOptions& options);

/// Invariants that every branch must satisfy; one sentence per violation, empty if all hold: points re-satisfy the equations,
/// arclength grows, stored stability equals recomputed, special points lie in their interval, the unstable count jumps across
/// them.
std::vector<std::string> check_branch(const HybridSystem& system, const Branch& branch);

}  // namespace graze
