// SPDX-License-Identifier: GPL-3.0-or-later
// Rest: a mass held at its stop by a force that presses it there, in the sticking mode of an event with an Accumulation.
//
// A stretch that is wholly held has a first-order map of its own. A small disturbance bounces, and the bounces decide.
//   * Each loses energy (ln|det S| < 0): the series ends within the stretch. The map is the limit of S for an impact of no speed
//     that ends in the sticking mode, the derivative of Accumulation::reset and what damping does to the other coordinates
//     meanwhile. For one mass it is zero: exponents -infinity.
//   * None loses energy (k_r = 1): the bounces never end. Of height y and speed v at the stop, under a slowly varying pressing
//     acceleration a, they keep the action v^3 / a but for the divergence D = trace(f_x) of the free flow, and it shrinks as
//     e^(D t): v as e^(D t / 3), y as e^(2 D t / 3). These are no derivatives, for there are none. They are the rates at which
//     a disturbance grows, so they stand for the map: diag(e^(2 D t / 3), e^(D t / 3)), with exponents D / 3 and 2 D / 3.
#pragma once

#include <graze/lib/motion/propagator.hpp>

namespace graze {

/// The event whose accumulation ends in this mode; null if it is not a sticking mode.
const Event* holding_event(const HybridSystem& system, std::size_t mode);

/// Whether an impact does, so that small bounces end.
bool loses_energy(const Event& event, const Vector& p);

/// First-order map over `duration` of a mass held at the state x in a mode that `holding` leads to, and ln|det| of it. NaN
/// where impacts lose nothing and the states are not (x, v).
struct HeldMap {
  Matrix Phi;
  double log_det = 0.0;  ///< -infinity if it forgets
  Vector slope = {};     ///< change of the state by a shift of the guard; empty: none
};
HeldMap held_map(const HybridSystem& system, const Event& holding, double t, const Vector& x, const Vector& p, double duration);

/// The state in which a mass rests for ever at the stop that `state` is near: held there at forcing phase 0, and not released
/// within a forcing period, all other coordinates at the same place after it. Null: there is none, or the system is not forced.
std::optional<Vector> rest_for_ever(Propagator& propagator, const Vector& state);

/// Whether the motion from `state` at forcing phase 0 comes to that rest, or is in it: it is held there after a period, or it
/// bounces on the stop, many times a period, with an action that shrinks at the rate known from `held_map`.
bool comes_to_rest(Propagator& propagator, const Vector& state, const Vector& rest);

/// Bounces so small that they come to rest: up to this height over the stop, and up to this speed. Found by trial; 0: none are.
struct Bounces {
  double height = 0.0, speed = 0.0;
};
Bounces bounces_to_rest(Propagator& propagator, const Vector& rest);

}  // namespace graze
