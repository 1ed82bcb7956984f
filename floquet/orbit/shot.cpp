// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/returns.hpp>
#include <graze/floquet/orbit/shot.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/numerics/decompositions.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace graze {

namespace {

bool are_admissible(const std::vector<Vector>& states, const HybridSystem& system, const Vector& p) {
  return std::all_of(states.begin(), states.end(), [&](const Vector& x) { return mode_at(system, 0.0, x, p).has_value(); });
}

/// Growth of the tangent along one period from each of these states, multiplied.
double growth_along(Propagator& propagator, const std::vector<Vector>& states) {
  Matrix growth = Matrix::Identity(states.front().size(), states.front().size());
  Transition transition;
  for (const Vector& state : states) {
    carry_period(propagator, state, {.sensitivity = Sensitivity::state}, transition);
    growth = period_map(transition) * growth;
  }
  return spectral_radius(growth);
}

Shot shot_in_lanes(const TaskSlot& slot, const LaneOrbit& found) {
  Shot shot;
  shot.converged = found.converged;
  shot.given_up = found.given_up;
  if (!shot.converged) return shot;
  shot.delicate = found.delicate;
  shot.holds = found.stable();
  shot.multiplier = found.multipliers[0];
  StableOrbit& orbit = shot.orbit;
  orbit.period = static_cast<int>(found.states.size());
  orbit.duration = orbit.period * forcing_period(slot.system(), slot.p());
  std::transform(found.states.begin(), found.states.end(), std::back_inserter(orbit.states), vector_of);
  orbit.impacts = orbit.isolated_impacts = found.impacts;  // the lanes leave sticking orbits to shoot()
  orbit.multipliers = multipliers_of_values({found.multipliers.begin(), found.multipliers.end()}, orbit.duration);
  return shot;
}

Shot shot_by_propagator(Propagator& propagator, const std::vector<Vector>& guess, const NewtonPatience& patience) {
  Shot shot;
  shot.by_propagator = true;
  shot.given_up = std::isfinite(patience.most_growth) && growth_along(propagator, guess) > patience.most_growth;
  if (shot.given_up) return shot;
  const SharedSystem& system = propagator.system();
  ShootingOptions shooting;
  shooting.flow = propagator.options();
  shooting.max_halvings = patience.max_halvings;
  PeriodicOrbit found = is_forced(system)
                            ? shoot(system, propagator.parameters(), guess, static_cast<int>(guess.size()), shooting)
                            : at_returns(system, shoot_returns(propagator, guess, shooting), guess.front());
  shot.converged = found.converged();
  if (!shot.converged) return shot;
  shot.holds = (found.stable() || found.neutral()) && found.admissible == Admissibility::admissible;
  if (found.multipliers.valid) shot.multiplier = found.multipliers.values.front();
  shot.orbit = StableOrbit(std::move(found));
  return shot;
}

}  // namespace

MotionTask<Shot> shoot_from(TaskSlot& slot, const std::vector<Vector>& guess, NewtonPatience patience) {
  if (!are_admissible(guess, slot.system(), slot.p())) co_return Shot();
  if (!slot.in_lanes()) co_return shot_by_propagator(slot.propagator(), guess, patience);
  const LaneOrbit found = co_await shoot_in_lanes(slot, guess, patience);
  co_return shot_in_lanes(slot, found);
}

}  // namespace graze
