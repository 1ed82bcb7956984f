// SPDX-License-Identifier: GPL-3.0-or-later
// LaneOrbit: Newton's method for many periodic orbits in parallel. The nodes of all orbits, one per forcing period, are motions
// of one period each, carried in SIMD lanes (LaneCarrier). Equations, steps and stop rules are those of shoot() with its
// default options (except for NewtonPatience), so that both find the same orbit, within the acceptance of Newton's method. The
// orbits are only tested for stability: the multipliers follow from trace and determinant of the monodromy matrix, the
// determinant factor by factor.
#pragma once

#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/tasks/task.hpp>

#include <array>
#include <complex>
#include <limits>
#include <vector>

namespace graze {

class TaskSlot;

struct LaneOrbit {
  bool converged = false;
  bool given_up = false;  ///< at once, because of NewtonPatience::most_growth
  /// shoot() must decide: the lanes left a node to the Propagator, or the monodromy matrix does not determine the multipliers
  /// to 1e-10, or whether they lie inside the unit circle.
  bool delicate = false;
  std::vector<std::array<double, 2>> states = {};        ///< at forcing phase 0, one per period of its least period
  std::array<std::complex<double>, 2> multipliers = {};  ///< by decreasing modulus
  int impacts = 0;
  bool stable() const { return std::abs(multipliers[0]) < 1.0; }
};

/// When to give up a guess: at once if the tangent along its states has an eigenvalue larger than most_growth over its period,
/// and later if max_halvings halvings of a step do not reduce the residual.
struct NewtonPatience {
  double most_growth = std::numeric_limits<double>::infinity();
  int max_halvings = ShootingOptions{}.max_halvings;
};

/// The orbit to which Newton's method converges from these states, one per period, at the parameters of the slot. Its motions
/// must be carried in lanes.
MotionTask<LaneOrbit> shoot_in_lanes(TaskSlot& slot, const std::vector<Vector>& guess, NewtonPatience patience = {});

}  // namespace graze
