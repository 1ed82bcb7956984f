// SPDX-License-Identifier: GPL-3.0-or-later
// Computation of one periodic orbit by Newton's method on the shooting equations.
#pragma once

#include <graze/floquet/orbit/orbit_shape.hpp>
#include <graze/floquet/orbit/periodic_orbit.hpp>
#include <graze/floquet/orbit/shooting_equations.hpp>
#include <graze/lib/numerics/newton.hpp>

namespace graze {

struct ShootingOptions {
  int nodes = 0;              ///< shooting nodes; 0: one per forcing period
  double tolerance = 1e-13;   ///< of the residual, relative to 1 + |x|; below it Newton continues while it improves
  double acceptance = 1e-12;  ///< a residual that stalls below this counts as converged
  int max_iterations = 40;
  int max_halvings = 12;            ///< of a Newton step that does not reduce the residual
  double max_step = 0.5;            ///< longest Newton step, relative to 1 + |x|
  bool reduce_period = true;        ///< an orbit of period n that closes after a divisor of n is returned with its least period
  bool finite_differences = false;  ///< also compute OrbitChecks::finite_difference
  FlowOptions flow = {};
};

/// The rule of Newton's method for orbits, on any kind of motion.
NewtonRule newton_rule(const ShootingOptions& options);

/// Newton from `guess` (state at phase 0, or several states at equally spaced times for multiple shooting). An autonomous
/// system needs `duration_guess`. The result is always returned; converged() tells whether it is an orbit.
/// @throws std::invalid_argument for parameters out of range or an inadmissible guess.
PeriodicOrbit shoot(const HybridSystem& system, const Vector& p, const std::vector<Vector>& guess, int period,
                    const ShootingOptions& options = {}, double duration_guess = 0.0);
inline PeriodicOrbit shoot(const HybridSystem& system, const Vector& p, const Vector& guess, int period,
                           const ShootingOptions& options = {}) {
  return shoot(system, p, std::vector<Vector>{guess}, period, options);
}

/// All properties of an orbit with known nodes: events, monodromy, multipliers, checks, and admissibility by free
/// re-simulation. `report` describes the computation of the nodes.
PeriodicOrbit describe_orbit(ShootingEquations& equations, const Vector& u, NewtonReport report);
/// The same for nodes that another method has found: the orbit is converged if their residual is below residual_allowed.
PeriodicOrbit describe_orbit(ShootingEquations& equations, const Vector& u);

/// Residual, relative to 1 + |x|, that nodes on an orbit may leave: 1e-11 and, after weak impacts, 1e-12 divided by their speeds
/// (below 0.1) or by the lowest speed. The state after an impact has the error of the state before it divided by its speed.
double residual_allowed(const std::vector<EventRecord>& events);

/// Compares the finite-difference monodromy matrix with the variational one (Richardson, step kept inside the signature's
/// domain).
FiniteDifferenceCheck finite_difference_check(const HybridSystem& system, const PeriodicOrbit& orbit,
                                              const FlowOptions& options = {});

}  // namespace graze
