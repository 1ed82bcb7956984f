// SPDX-License-Identifier: GPL-3.0-or-later
// Rest: a mass held at its stop by a pressing force, in the sticking mode of an event with an Accumulation.
//
// A stretch that is held from beginning to end has a first-order map of its own. A small disturbance bounces, and the bounces
// determine the map.
//   * Each bounce loses energy (ln|det S| < 0): the series ends within the stretch. The map is the limit of S for an impact of
//     zero speed that ends in the sticking mode: the derivative of Accumulation::reset, plus the effect of damping on the other
//     coordinates meanwhile. For one mass it is zero: exponents -infinity.
//   * No bounce loses energy (k_r = 1): the bounces never end. Under a slowly varying pressing acceleration a, a bounce of
//     height y and speed v at the stop conserves the action v^3 / a, except for the divergence D = trace(f_x) of the free flow:
//     the action shrinks as e^(D t), v as e^(D t / 3), y as e^(2 D t / 3). The map has no derivative here. These growth rates
//     of a disturbance take its place: diag(e^(2 D t / 3), e^(D t / 3)), with exponents D / 3 and 2 D / 3.
#pragma once

#include <graze/lib/motion/propagator.hpp>

#include <span>

namespace graze {

/// The event whose accumulation ends in this mode; null if the mode is not a sticking mode.
const Event* holding_event(const HybridSystem& system, std::size_t mode);

/// Whether an impact of this event loses energy, so that small bounces end.
bool loses_energy(const Event& event, const Vector& p);

/// First-order map over `duration` of a mass held at the state x in a mode that `holding` leads to, and its ln|det|. NaN if
/// impacts lose no energy and the states are not (x, v).
struct HeldMap {
  Matrix Phi;
  double log_det = 0.0;  ///< -infinity if the map is singular
  Vector slope = {};     ///< derivative of the state in a shift of the guard; empty: zero
};
HeldMap held_map(const HybridSystem& system, const Event& holding, double t, const Vector& x, const Vector& p, double duration);

/// Loss of a small disturbance off constraints that hold, x+ = x - D (C D)^-1 c, with the constraints c, their gradients C and
/// their directions D.
struct ConstraintMap {
  Matrix dx;  ///< I - D (C D)^-1 C (n x n)
  Matrix dp;  ///< -D (C D)^-1 C_dp (n x number of active parameters)
};
/// Empty if the fields on both sides are parallel to the constraints, or if the mode at `at` holds a mass whose bounces never
/// end.
std::optional<ConstraintMap> constraint_map(const HybridSystem& system, std::span<const Constraint* const> constraints,
                                            const HybridState& at, const Vector& p, std::span<const std::size_t> active);

/// Moves a state near the constraints of a mode onto them, along their directions: the motion itself does that at once. False:
/// they are not reached, or not within `farthest` (1 + |x|).
bool settle_on_constraints(const HybridSystem& system, std::size_t mode, double t, const Vector& p, Vector& x,
                           double farthest = 1e-2);

/// The mode of a state in which friction holds a body, and no stop does; empty: there is none.
std::optional<std::size_t> held_by_friction(const HybridSystem& system, double t, const Vector& x, const Vector& p);

/// A body that friction holds at the parameters `before` is held at p too (a belt that runs faster takes it along): moves a state
/// onto the constraints of its mode there. Other states stay.
void keep_held(const HybridSystem& system, double t, const Vector& before, const Vector& p, Vector& x);

/// The state of permanent rest at the stop near `state`: held there at forcing phase 0, not released within a forcing period,
/// and with all other coordinates at the same place after it. Empty: there is none, or the system is not forced.
std::optional<Vector> permanent_rest(Propagator& propagator, const Vector& state);

/// Whether the motion from `state` at forcing phase 0 reaches that rest or is in it: it is held there after a period, or it
/// bounces on the stop, many times a period, with an action that shrinks at the rate of `held_map`.
bool reaches_rest(Propagator& propagator, const Vector& state, const Vector& rest);

/// Largest bounces that come to rest: height above the stop and speed, found by trial. 0: none do.
struct Bounces {
  double height = 0.0, speed = 0.0;
};
Bounces bounces_to_rest(Propagator& propagator, const Vector& rest);

}  // namespace graze
