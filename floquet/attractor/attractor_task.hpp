// SPDX-License-Identifier: GPL-3.0-or-later
// The two halves of find_attractor (attractor.hpp) as tasks of a pool (TaskPool).
//
// In fast mode (AttractorOptions::recurrence > 0) and with periods_on_orbit = 0, the motion shares the SIMD lanes with those of
// other tasks if the lanes support the system; otherwise a Propagator carries it. The result does not depend on the other tasks.
// Orbits found in lanes are not whole.
#pragma once

#include <graze/floquet/attractor/attractor.hpp>
#include <graze/lib/tasks/task.hpp>

namespace graze {

class TaskSlot;

MotionTask<Attractor> approach_attractor(TaskSlot& slot, const Vector& p, const Vector& start, const AttractorOptions& options);
MotionTask<> average_on_attractor(TaskSlot& slot, const Vector& p, Attractor& attractor, const AttractorOptions& options);

}  // namespace graze
