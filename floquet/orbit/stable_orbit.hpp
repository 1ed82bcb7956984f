// SPDX-License-Identifier: GPL-3.0-or-later
// StableOrbit: an orbit on which a motion settles, with its states and multipliers. It is lighter than a PeriodicOrbit: many of
// them are found in SIMD lanes, by Newton's method on the states at forcing phase 0 alone.
#pragma once

#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <memory>
#include <utility>
#include <vector>

namespace graze {

/// A stable orbit or, in a conservative system, a neutral one. All times are dimensionless.
struct StableOrbit {
  StableOrbit() = default;
  /// The same of a whole orbit, which is kept.
  explicit StableOrbit(PeriodicOrbit orbit)
      : period(orbit.period), duration(orbit.duration), states(orbit.states), impacts(orbit.impacts),
        isolated_impacts(orbit.isolated_impacts), rests(orbit.rests), conservative(orbit.conservative),
        multipliers(orbit.multipliers), whole(std::make_shared<const PeriodicOrbit>(std::move(orbit))) {}

  int period = 0;              ///< forcing periods, or returns of an autonomous motion
  double duration = 0.0;       ///< of these periods
  std::vector<Vector> states;  ///< at forcing phase 0 after 0 ... period - 1 periods; autonomous: right after the returns
  int impacts = 0;             ///< as in PeriodicOrbit, and the next three
  int isolated_impacts = 0;
  bool rests = false;
  bool conservative = false;
  FloquetMultipliers multipliers;
  std::shared_ptr<const PeriodicOrbit> whole;  ///< with events and checks; null if it was found in lanes

  bool neutral() const { return conservative && multipliers.neutral(); }
};

}  // namespace graze
