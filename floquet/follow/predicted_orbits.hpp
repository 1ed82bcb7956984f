// SPDX-License-Identifier: GPL-3.0-or-later
// The stable orbits at the next values of a parameter, all at once: guessed by extrapolation from those at the values before,
// found by Newton's method side by side in SIMD lanes, and kept as far as the motion on each comes to the next: where a motion
// that is followed from value to value ends, for a tenth of what following it costs.
#pragma once

#include <graze/floquet/orbit/periodic_orbit.hpp>
#include <graze/lib/flow/flow.hpp>

#include <vector>

namespace graze {

/// Orbits of so many values may say what comes next: a polynomial of their states at phase 0, of degree 3 at the most.
inline constexpr std::size_t most_orbits_before = 4;

struct OrbitAhead {
  PeriodicOrbit orbit;
  std::vector<double> impact_speeds;  ///< of its impacts (entries)
};

/// `before`: the states at phase 0 of orbits of the same period, at equidistant values, the last one last; `next`: the parameters
/// at the values that follow. The orbits at the first of them, up to the first that is not found, not stable, delicate for the
/// lanes, or not what the motion on the one before comes to; each begins where that before it did, and comes as from
/// look_for_orbit_in_lanes. None where fewer than two orbits are known, or the lanes do not know the oscillator.
std::vector<OrbitAhead> orbits_ahead(const HybridSystem& system, const std::vector<std::vector<Vector>>& before,
                                     const std::vector<Vector>& next, const FlowOptions& flow = {});

}  // namespace graze
