// SPDX-License-Identifier: GPL-3.0-or-later
// GrazingEdge: the end of a family of orbits at a grazing of a hard contact. Families that share one are the same.
#pragma once

#include <graze/continuation/grazing.hpp>
#include <graze/continuation/special_point.hpp>

#include <vector>

namespace graze {

struct GrazingEdge {
  double value = 0.0;  ///< of the continuation parameter
  int period = 0;
  int impacts = 0;  ///< of the family that ends there
  std::vector<Vector> states;
};

bool same_edge(const GrazingEdge& a, const GrazingEdge& b);

GrazingEdge edge_at(const SpecialPoint& point, const PeriodicOrbit& orbit, int impacts);

/// Without its weak impact an orbit may close after a divisor of its period: then that shorter orbit is the one beyond the
/// grazing. Shortens both and returns the period.
int to_least_period(PeriodicOrbit& orbit, LocatedGrazing& grazing);

/// Of the family beyond the grazing `point`. Where its orbits are shorter, `grazing` (and the orbit written to `orbit`) are too.
GrazingEdge partner_edge(const SpecialPoint& point, LocatedGrazing& grazing, bool lost, PeriodicOrbit* orbit = nullptr);

}  // namespace graze
