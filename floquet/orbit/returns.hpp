// SPDX-License-Identifier: GPL-3.0-or-later
// Periodic orbits of autonomous systems, from the returns of a motion (returns_of in hybrid_system.hpp, carry_period in
// transition.hpp), which stand for its forcing periods. A return lies on a guard, at which shooting has no derivative: Newton's
// method begins in the middle of the longest flight without an event instead.
#pragma once

#include <graze/floquet/orbit/shooting.hpp>

#include <optional>
#include <vector>

namespace graze {

/// A motion in the middle of its longest flight within some returns, and the time that these returns take.
struct Midway {
  Vector state;
  double duration = 0.0;
};

/// From `state`, within `returns` returns. Empty: the motion does not return so often.
std::optional<Midway> midway(Propagator& propagator, const Vector& state, int returns = 1);

/// The orbit near a motion that nearly closes after as many returns as there are states, the first of them at the front. Its own
/// state is off the guards, and its period is 1, as shoot() has it. Not converged: there is none that returns.
PeriodicOrbit shoot_returns(Propagator& propagator, const std::vector<Vector>& states, const ShootingOptions& options = {});

/// The orbit as a motion at its returns sees it: `period` counts its returns, `states` are right behind them, that nearest to
/// `first` at the front. Its nodes stay.
PeriodicOrbit seen_at_returns(const HybridSystem& system, PeriodicOrbit orbit, const Vector& first);

/// How often it returns.
int count_returns(const HybridSystem& system, const PeriodicOrbit& orbit);

/// The same back: as shoot() has it, at the first of its nodes. A forced orbit stays as it is.
PeriodicOrbit seen_at_nodes(PeriodicOrbit orbit);

}  // namespace graze
