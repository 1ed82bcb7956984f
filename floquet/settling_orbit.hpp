// SPDX-License-Identifier: GPL-3.0-or-later
// The stable orbit that a motion is settling on, known by Newton's method and not by a tolerance on its samples.
#pragma once

#include <graze/floquet/shooting.hpp>
#include <graze/lib/many_motions.hpp>

#include <optional>
#include <vector>

namespace graze {

/// The stable orbit that a motion at `state` is settling on, if it is periodic with period up to max_period.
std::optional<PeriodicOrbit> settling_orbit(Propagator& propagator, const Vector& state, int max_period);
std::optional<PeriodicOrbit> settling_orbit(const HybridSystem& system, const Vector& p, const Vector& state, int max_period,
                                            const FlowOptions& flow = {});

/// The states that follow one, and after how many periods the motion is back within a distance, the closest return first.
struct Returns {
  std::vector<Vector> states;
  std::vector<int> periods;
};

/// Those of up to max_period periods; `nearness` is relative to 1 + |x|.
Returns close_returns(Propagator& propagator, const Vector& state, int max_period, double nearness);

/// settling_orbit where time matters: the few closest returns are tried, and only returns within `nearness`.
std::optional<PeriodicOrbit> orbit_of_close_returns(Propagator& propagator, const Vector& state, int max_period, double nearness);

/// A motion that may be settling on an orbit, among others.
struct SettlingMotion {
  std::size_t parameters = 0;  ///< as ManyMotions knows them
  Vector p;                    ///< the same
  Vector state;
  int max_period = 1;
};

/// What it is settling on.
struct SettlingLook {
  std::optional<PeriodicOrbit> orbit;
  int closest = 0;  ///< after how many periods the closest return was; 0: there was none
};

/// orbit_of_close_returns of many motions side by side in lanes, to the same orbits. Except where an orbit is delicate
/// (lane_orbits.hpp), they come without events, signature, monodromy matrix and checks.
std::vector<SettlingLook> look_for_orbits(const HybridSystem& system, ManyMotions& many,
                                          const std::vector<SettlingMotion>& motions, double nearness,
                                          const FlowOptions& flow = {});

/// Those of some states, of the same parameters, from which a motion may be settling on a stable orbit: its tangent does not grow
/// for long. (In chaos it does; to find that out for all is less work than settling_orbit has with a few.) Carried in lanes.
std::vector<Vector> that_may_settle(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states,
                                    const FlowOptions& flow = {});

}  // namespace graze
