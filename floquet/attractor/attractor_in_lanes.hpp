// SPDX-License-Identifier: GPL-3.0-or-later
// The two halves of find_attractor for a motion that shares the SIMD lanes of a thread with others (TaskPool).
#pragma once

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/lib/tasks/task.hpp>

namespace graze {

class TaskSlot;

/// approach_attractor and average_on_attractor in the lanes, if these support the oscillator, AttractorOptions::recurrence > 0
/// and periods_on_orbit = 0; otherwise the scalar versions run. The result does not depend on the other motions. Orbits have
/// the form given by look_for_orbit_in_lanes.
MotionTask<Attractor> approach_attractor_in_lanes(TaskSlot& lane, const HybridSystem& system, const Vector& p,
                                                  const Vector& start, const AttractorOptions& options);
MotionTask<> average_on_attractor_in_lanes(TaskSlot& lane, const HybridSystem& system, const Vector& p, Attractor& attractor,
                                           const AttractorOptions& options);

}  // namespace graze
