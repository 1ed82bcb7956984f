// SPDX-License-Identifier: GPL-3.0-or-later
// The two halves of find_attractor where its motion shares the lanes of a thread with others (LanePool).
#pragma once

#include <graze/floquet/attractor.hpp>
#include <graze/lib/lane_task.hpp>

namespace graze {

class LanePlace;

/// approach_attractor and average_on_attractor there, where the lanes know the oscillator, AttractorOptions::recurrence > 0 and
/// periods_on_orbit = 0; else by themselves. What comes out does not depend on the others. Orbits come as from
/// look_for_orbit_in_lanes.
LaneTask<Attractor> approach_attractor_in_lanes(LanePlace& lane, const HybridSystem& system, const Vector& p, const Vector& start,
                                                const AttractorOptions& options);
LaneTask<> average_on_attractor_in_lanes(LanePlace& lane, const HybridSystem& system, const Vector& p, Attractor& attractor,
                                         const AttractorOptions& options);

}  // namespace graze
