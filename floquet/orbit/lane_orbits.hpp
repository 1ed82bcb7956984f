// SPDX-License-Identifier: GPL-3.0-or-later
// LaneOrbit: Newton's method for many periodic orbits in parallel. The nodes of all orbits, one per forcing period, are motions
// of one period each, carried in SIMD lanes (LaneCarrier). Equations, steps and stop rules are those of shoot() with its
// default options (except for LanePatience), so that both find the same orbit, within the acceptance of Newton's method. The
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
class LaneCarrier;

struct LaneGuess {
  std::size_t parameters = 0;                 ///< index in LaneCarrier
  std::vector<std::array<double, 2>> states;  ///< at forcing phase 0, one per period of the orbit
};

/// The guess through these states, at the parameter set `parameters`.
LaneGuess guess_of(std::size_t parameters, const std::vector<Vector>& states);

struct LaneOrbit {
  bool converged = false;
  bool given_up = false;  ///< at once, because of LanePatience::most_growth
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
struct LanePatience {
  double most_growth = std::numeric_limits<double>::infinity();
  int max_halvings = ShootingOptions{}.max_halvings;
};

/// The orbit to which Newton's method converges from these states, at the parameters of the slot.
MotionTask<LaneOrbit> shoot_in_lanes(TaskSlot& lane, std::vector<std::array<double, 2>> states, LanePatience patience = {});

/// The same for many guesses in parallel.
std::vector<LaneOrbit> shoot_together(LaneCarrier& many, const std::vector<LaneGuess>& guesses, LanePatience patience = {});
/// The same at the parameters p; empty if the lanes do not support the system there.
std::vector<LaneOrbit> shoot_together(const HybridSystem& system, const Vector& p,
                                      const std::vector<std::vector<Vector>>& guesses, LanePatience patience,
                                      const FlowOptions& flow, bool all_threads);

}  // namespace graze
