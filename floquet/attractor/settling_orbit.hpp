// SPDX-License-Identifier: GPL-3.0-or-later
// The stable orbit on which a motion is settling, found by Newton's method rather than by a tolerance on samples.
#pragma once

#include <graze/floquet/orbit/lane_orbits.hpp>
#include <graze/floquet/orbit/stable_orbit.hpp>

#include <optional>
#include <vector>

namespace graze {

class RefusedOrbits;

/// The stable orbit on which a motion at `state` is settling, if it is periodic with period up to max_period. `all_threads`:
/// work in lanes uses all threads of the caller's arena (oneTBB); the result does not depend on this.
std::optional<PeriodicOrbit> settling_orbit(Propagator& propagator, const Vector& state, int max_period,
                                            bool all_threads = false);
std::optional<PeriodicOrbit> settling_orbit(const HybridSystem& system, const Vector& p, const Vector& state, int max_period,
                                            const FlowOptions& flow = {});

/// The orbit of a mass that rests forever at its stop (lib/rest.hpp), if the motion at `state` is on it or reaches it. Every
/// search for an orbit tries this first. `may_rest` is a cheap test that excludes it.
std::optional<PeriodicOrbit> resting_orbit(Propagator& propagator, const Vector& state);
bool may_rest(const HybridSystem& system, const Vector& p, const Vector& state);

/// Returns after at most this many periods need not be as close as longer ones.
inline constexpr int short_return = 64;

/// Result of a search for the orbit on which a motion is settling.
struct OrbitSearchResult {
  std::optional<StableOrbit> orbit;
  int closest = 0;  ///< periods of the closest return; 0: none
};

/// Faster settling_orbit for a task, at the parameters of its slot: tries only the few closest returns, and only those within
/// `nearness`, relative to 1 + |x|. In lanes, the orbit is whole only in delicate cases (lane_orbits.hpp). `refused`: orbits that
/// the motion was seen to pass; orbits that it passes now are added.
MotionTask<OrbitSearchResult> look_for_orbit(TaskSlot& lane, const HybridSystem& system, const Vector& p, const Vector& state,
                                             int max_period, double nearness, const FlowOptions& flow = {},
                                             RefusedOrbits* refused = nullptr);

/// Number of periods after which the motion from `state` returns most closely, among up to max_period; 0: not within `nearness`.
MotionTask<int> closest_return(TaskSlot& lane, const Vector& state, int max_period, double nearness);

/// The orbit found in lanes (with quick_halvings), if it is stable and not delicate, and the motion at `state` near it approaches
/// it. Uses the parameters of the slot. The orbit is not whole.
MotionTask<std::optional<StableOrbit>> orbit_approached_in_lanes(TaskSlot& lane, const HybridSystem& system, const Vector& p,
                                                                 const LaneOrbit& orbit, const Vector& state);

/// The states from which a motion may be settling on a stable orbit: the tangent does not keep growing. In chaos it does;
/// testing all states for this costs less than running settling_orbit on a few. All states have the same parameters.
/// `all_threads`: uses all threads of the caller's arena (oneTBB); the result does not depend on this.
std::vector<Vector> settling_candidates(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states,
                                        const FlowOptions& flow = {}, bool all_threads = false);

}  // namespace graze
