// SPDX-License-Identifier: GPL-3.0-or-later
// LaneOrbit: Newton's method for many periodic orbits side by side: the nodes of all of them, one per forcing period, are motions
// of one period each, carried in SIMD lanes (LaneCarrier). Equations, steps and ends are those of shoot() with its default
// options (but for LanePatience), so that both come to the same orbit, within the acceptance of Newton's method. What an orbit is
// wanted for here is whether it is stable: its multipliers come from trace and determinant of its monodromy matrix, the
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
class LaneCarrier;

struct LaneGuess {
  std::size_t parameters = 0;                 ///< as LaneCarrier knows them
  std::vector<std::array<double, 2>> states;  ///< at forcing phase 0 of as many periods as the orbit has
};

struct LaneOrbit {
  bool converged = false;
  bool given_up = false;  ///< at once: LanePatience::most_growth
  /// Wants shoot() to decide: a node that the lanes left to the Propagator, or a monodromy matrix that does not tell the
  /// multipliers to 1e-10, or whether they are inside the unit circle.
  bool delicate = false;
  std::vector<std::array<double, 2>> states = {};        ///< at forcing phase 0; as many as its least period
  std::array<std::complex<double>, 2> multipliers = {};  ///< by decreasing modulus
  int impacts = 0;
  bool stable() const { return std::abs(multipliers[0]) < 1.0; }
};

/// When a guess is given up: at once where the tangent of the motions from its states has an eigenvalue larger than most_growth
/// over its period, and where a step does not reduce the residual however often it is halved.
struct LanePatience {
  double most_growth = std::numeric_limits<double>::infinity();
  int max_halvings = ShootingOptions{}.max_halvings;
};

/// The orbit that Newton's method comes to from these states, at the parameters of the place.
MotionTask<LaneOrbit> shoot_in_lanes(TaskSlot& lane, std::vector<std::array<double, 2>> states, LanePatience patience = {});

/// The same of many guesses side by side.
std::vector<LaneOrbit> shoot_side_by_side(LaneCarrier& many, const std::vector<LaneGuess>& guesses, LanePatience patience = {});

}  // namespace graze
