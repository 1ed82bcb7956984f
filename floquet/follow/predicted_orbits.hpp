// SPDX-License-Identifier: GPL-3.0-or-later
// The stable orbits at the next values of a parameter, computed together. The guesses are extrapolated from the orbits at the
// previous values, and Newton's method runs on all of them as tasks of a pool. An orbit is kept if the motion from the one before
// approaches it: a motion followed from value to value would end there, at ten times the cost.
#pragma once

#include <graze/floquet/orbit/stable_orbit.hpp>
#include <graze/lib/flow/flow.hpp>
#include <graze/lib/system/shared_system.hpp>
#include <graze/lib/tasks/task.hpp>

#include <vector>

namespace graze {

class TaskSlot;

/// Orbits at up to this many values are used for extrapolation: a polynomial of their states at phase 0, of degree 3 at most.
inline constexpr std::size_t most_orbits_before = 4;

struct PredictedOrbit {
  StableOrbit orbit;
  std::vector<double> impact_speeds;  ///< of its impacts (entries into contact)
};

/// Speeds of the impacts (entries into contact) of an orbit at the parameters p, for a task.
MotionTask<std::vector<double>> impact_speeds_of(TaskSlot& slot, const Vector& p, const StableOrbit& orbit);

/// `before`: states at phase 0 of orbits of the same period at equidistant values, the last one last; `next`: the parameters at
/// the values that follow. Returns the orbits at the first of these, up to the first one that is not found, not stable, or not
/// approached by the motion from the one before. Each begins at the state that continues the one before. Empty if fewer than two
/// orbits are known.
std::vector<PredictedOrbit> predicted_orbits(const SharedSystem& system, const std::vector<std::vector<Vector>>& before,
                                             const std::vector<Vector>& next, const FlowOptions& flow = {});

}  // namespace graze
