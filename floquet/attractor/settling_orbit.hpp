// SPDX-License-Identifier: GPL-3.0-or-later
// The stable orbit on which a motion is settling, found by Newton's method rather than by a tolerance on samples.
#pragma once

#include <graze/floquet/orbit/shot.hpp>

#include <optional>
#include <vector>

namespace graze {

class RefusedOrbits;

/// The orbit of a mass that rests forever at its stop (lib/motion/rest.hpp), if the motion at `state` is on it or reaches it.
/// Every search for an orbit tries this first. `may_rest` is a cheap test that excludes it.
std::optional<PeriodicOrbit> resting_orbit(Propagator& propagator, const Vector& state);
bool may_rest(const HybridSystem& system, const Vector& p, const Vector& state);

/// Returns after at most this many periods need not be as close as longer ones.
inline constexpr int short_return = 64;

/// Result of a search for the orbit on which a motion is settling.
struct OrbitSearchResult {
  std::optional<StableOrbit> orbit;
  int closest = 0;  ///< periods of the closest return; 0: none
};

/// How an orbit is sought.
struct OrbitSearch {
  int max_period = 64;  ///< longest period tried
  /// > 0: only the few closest returns are tried, and only those within this distance, relative to 1 + |x|. The orbit is then
  /// whole only where a Shot is. 0: exhaustive; every return that may have settled is tried, and the orbit is whole.
  double nearness = 0.0;
  /// Of a search among the closest returns: orbits that the motion was seen to pass; those that it passes now are added. May be
  /// null. An exhaustive search tries all of them again.
  RefusedOrbits* refused = nullptr;
  bool all_threads = false;  ///< an exhaustive search uses all threads of the caller's arena (oneTBB); its result is the same
};

/// The stable orbit on which the motion at `state` is settling, for a task, at the parameters of its slot.
MotionTask<OrbitSearchResult> look_for_orbit(TaskSlot& slot, const Vector& state, OrbitSearch search);
/// The same by an exhaustive search alone.
std::optional<StableOrbit> settling_orbit(const HybridSystem& system, const Vector& p, const Vector& state, int max_period,
                                          const FlowOptions& flow = {});

/// Number of periods after which the motion from `state` returns most closely, among up to max_period; 0: not within `nearness`.
MotionTask<int> closest_return(TaskSlot& slot, const Vector& state, int max_period, double nearness);

/// The orbit found, if it is stable and the motion at `state` near it approaches it. Uses the parameters of the slot.
MotionTask<std::optional<StableOrbit>> orbit_approached(TaskSlot& slot, const Shot& shot, const Vector& state);

/// The states from which a motion may be settling on a stable orbit: the tangent does not keep growing. In chaos it does;
/// testing all states for this costs less than an exhaustive search from a few. All states have the same parameters.
/// `all_threads`: uses all threads of the caller's arena (oneTBB); the result does not depend on this.
std::vector<Vector> settling_candidates(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states,
                                        const FlowOptions& flow = {}, bool all_threads = false);

}  // namespace graze
