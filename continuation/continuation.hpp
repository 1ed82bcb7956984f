// SPDX-License-Identifier: GPL-3.0-or-later
// Following periodic orbits in a parameter: the branch through an orbit, and the branches born on it.
#pragma once

#include <graze/continuation/branch.hpp>
#include <graze/continuation/trace.hpp>
#include <graze/floquet/shooting.hpp>

#include <functional>

namespace graze {

struct ContinuationOptions {
  std::string parameter = "eta";
  double to = 0.0;                  ///< the branch is followed until the parameter gets here
  std::optional<double> from = {};  ///< other end of the range, for branches that turn or are born on the way; empty: the start
  int switch_generations = 1;       ///< generations of period-doubled branches that are followed
  /// At a hard grazing the families of 2, 3 ... times the period of the orbit that grazes are followed too, up to this many times
  /// (and to max_period). They count as a generation. 1: none of them.
  int max_multiple = 1;
  int max_branches = 64;
  int max_period = 0;            ///< branches of longer period are not followed; 0: no limit
  bool follow_parents = false;   ///< where a doubled branch returns to an orbit of half its period, that one is followed too
  int threads = 1;               ///< branches are followed side by side; the result does not depend on it
  bool both_directions = false;  ///< also follow the first branch the other way, as far as the range goes
  TraceOptions trace = {};
  ShootingOptions shooting = {};
  std::vector<double> user_values = {};  ///< parameter values at which a point of type UZ is wanted
  std::function<bool()> cancelled = {};
  /// Called after each point with the branch so far (by one thread at a time).
  std::function<void(const Branch&)> progress = {};
  /// Called now and then with the branches that are complete, as an interruption would leave them.
  std::function<void(const std::vector<Branch>&)> complete = {};
};

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
