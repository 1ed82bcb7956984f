// SPDX-License-Identifier: GPL-3.0-or-later
// Shot: the orbit to which Newton's method converges from a guess, for a task. The nodes are the states after each period; the
// task's slot carries them side by side, with those of other tasks. Equations, steps and stop rule are those of shoot() with its
// default options (except for NewtonPatience), so that both find the same orbit, within the acceptance of Newton's method. The
// orbit is only tested for stability, by the multipliers of the monodromy matrix. Where these do not decide, and where a
// Propagator carried periods of a stable orbit (an orbit that sticks, or any one of a system without lanes), shoot() proves it.
#pragma once

#include <graze/floquet/orbit/shooting.hpp>
#include <graze/floquet/orbit/stable_orbit.hpp>
#include <graze/lib/tasks/task.hpp>

#include <complex>
#include <limits>
#include <vector>

namespace graze {

class TaskSlot;

struct Shot {
  bool converged = false;
  bool given_up = false;   ///< at once, because of NewtonPatience::most_growth
  bool holds = false;      ///< it is stable or neutral, and a motion
  StableOrbit orbit = {};  ///< if it converged; whole if shoot() has proved it

  /// The first one; NaN: unknown.
  std::complex<double> multiplier() const {
    return orbit.multipliers.valid ? orbit.multipliers.values.front() : std::numeric_limits<double>::quiet_NaN();
  }
};

/// When to give up a guess: at once if the tangent along its states has an eigenvalue larger than most_growth over its period,
/// and later if max_halvings halvings of a step do not reduce the residual.
struct NewtonPatience {
  double most_growth = std::numeric_limits<double>::infinity();
  int max_halvings = ShootingOptions{}.max_halvings;
};

/// The orbit of least period found from these states, one per period, at the parameters of the slot; none from a state inside a
/// barrier.
MotionTask<Shot> shoot_from(TaskSlot& slot, const std::vector<Vector>& guess, NewtonPatience patience = {});

}  // namespace graze
