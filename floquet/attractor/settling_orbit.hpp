// SPDX-License-Identifier: GPL-3.0-or-later
// The stable orbit that a motion is settling on, known by Newton's method and not by a tolerance on its samples.
#pragma once

#include <graze/floquet/orbit/lane_orbits.hpp>

#include <optional>
#include <vector>

namespace graze {

class RefusedOrbits;

/// The stable orbit that a motion at `state` is settling on, if it is periodic with period up to max_period. `all_threads`: of
/// the caller's arena (oneTBB), for what is done in lanes; the result does not depend on them.
std::optional<PeriodicOrbit> settling_orbit(Propagator& propagator, const Vector& state, int max_period,
                                            bool all_threads = false);
std::optional<PeriodicOrbit> settling_orbit(const HybridSystem& system, const Vector& p, const Vector& state, int max_period,
                                            const FlowOptions& flow = {});

/// The orbit of a mass that rests for ever at its stop (lib/rest.hpp), if the motion at `state` is in it or comes to it. All
/// that look for an orbit ask this first. `may_rest` tells where there is none, for little.
std::optional<PeriodicOrbit> resting_orbit(Propagator& propagator, const Vector& state);
bool may_rest(const HybridSystem& system, const Vector& p, const Vector& state);

/// A return after so many periods need not be as close as after more.
inline constexpr int short_return = 64;

/// The states that follow one, and after how many periods the motion is back within a distance, the closest return first.
struct Returns {
  std::vector<Vector> states;
  std::vector<int> periods;
};

/// Those of up to max_period periods; `nearness` is relative to 1 + |x|.
Returns close_returns(Propagator& propagator, const Vector& state, int max_period, double nearness);

/// settling_orbit where time matters: the few closest returns are tried, and only returns within `nearness`. `refused`: orbits
/// that the motion was seen to pass by; those that it passes by now are added.
std::optional<PeriodicOrbit> orbit_of_close_returns(Propagator& propagator, const Vector& state, int max_period, double nearness,
                                                    RefusedOrbits* refused = nullptr);

/// What a motion is settling on.
struct SettlingLook {
  std::optional<PeriodicOrbit> orbit;
  int closest = 0;  ///< after how many periods the closest return was; 0: there was none
};

/// orbit_of_close_returns in lanes, at the parameters of the place, to the same orbit. Except where it is delicate
/// (lane_orbits.hpp), it comes without events, signature, monodromy matrix and checks. `refused`: orbits that the motion was seen
/// to pass by; those that it passes by now are added.
MotionTask<SettlingLook> look_for_orbit_in_lanes(TaskSlot& lane, const HybridSystem& system, const Vector& p, const Vector& state,
                                                 int max_period, double nearness, const FlowOptions& flow = {},
                                                 RefusedOrbits* refused = nullptr);

/// An orbit found in lanes (few_halvings), if the motion at `state`, near it, comes closer to it, and it is stable and not
/// delicate; at the parameters of the place. It comes as from look_for_orbit_in_lanes.
MotionTask<std::optional<PeriodicOrbit>> orbit_approached_in_lanes(TaskSlot& lane, const HybridSystem& system, const Vector& p,
                                                                   const LaneOrbit& orbit, const Vector& state);

/// Those of some states, of the same parameters, from which a motion may be settling on a stable orbit: its tangent does not grow
/// for long. (In chaos it does; to find that out for all is less work than settling_orbit has with a few.) Carried in lanes.
std::vector<Vector> that_may_settle(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states,
                                    const FlowOptions& flow = {});

}  // namespace graze
