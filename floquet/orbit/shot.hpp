// SPDX-License-Identifier: GPL-3.0-or-later
// Shot: the orbit to which Newton's method converges from a guess, for a task. It is computed as the task's slot carries motions:
// in lanes a light orbit (lane_orbits.hpp), by a Propagator the whole one of shoot(), which proves its stability too.
#pragma once

#include <graze/floquet/orbit/lane_orbits.hpp>
#include <graze/floquet/orbit/stable_orbit.hpp>
#include <graze/lib/tasks/task.hpp>

#include <complex>
#include <limits>
#include <vector>

namespace graze {

class TaskSlot;

struct Shot {
  bool converged = false;
  bool given_up = false;       ///< at once, because of NewtonPatience::most_growth
  bool delicate = false;       ///< shoot() must decide (LaneOrbit::delicate)
  bool by_propagator = false;  ///< shoot() has decided
  bool holds = false;          ///< it is stable or neutral, and a motion
  std::complex<double> multiplier = std::numeric_limits<double>::quiet_NaN();  ///< the first; NaN: unknown
  StableOrbit orbit = {};                                                      ///< if it converged
};

/// The orbit found from these states, one per period, at the parameters of the slot; none from a state inside a barrier.
MotionTask<Shot> shoot_from(TaskSlot& slot, const std::vector<Vector>& guess, NewtonPatience patience);

}  // namespace graze
