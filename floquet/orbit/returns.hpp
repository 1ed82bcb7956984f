// SPDX-License-Identifier: GPL-3.0-or-later
// Periodic orbits of autonomous systems from the returns of a motion (returns_of in hybrid_system.hpp, carry_period in
// transition.hpp), which replace the forcing periods. A return lies on a guard, where shooting has no derivative: Newton's
// method therefore starts in the middle of the longest flight without an event.
#pragma once

#include <graze/floquet/orbit/shooting.hpp>

#include <optional>
#include <vector>

namespace graze {

/// State in the middle of the longest flight within some returns, and the total time of these returns.
struct Midway {
  Vector state;
  double duration = 0.0;
};

/// The midway state from `state` within `returns` returns. Empty if the motion does not return that often.
std::optional<Midway> midway(Propagator& propagator, const Vector& state, int returns = 1);

/// The orbit near a motion that nearly closes after states.size() returns; `states`: those at consecutive returns. The orbit's
/// own state is off the guards, and its period is 1, as in shoot(). Not converged if there is no orbit that returns.
PeriodicOrbit shoot_returns(Propagator& propagator, const std::vector<Vector>& states, const ShootingOptions& options = {});

/// The orbit as seen at its returns: `period` counts the returns, and `states` are those immediately after them, beginning with
/// the one nearest to `first`. Its nodes stay.
PeriodicOrbit at_returns(const HybridSystem& system, PeriodicOrbit orbit, const Vector& first);

/// Number of returns of the orbit.
int count_returns(const HybridSystem& system, const PeriodicOrbit& orbit);

/// The inverse: the orbit as from shoot(), at its first node. A forced orbit stays as it is.
PeriodicOrbit at_nodes(PeriodicOrbit orbit);

}  // namespace graze
