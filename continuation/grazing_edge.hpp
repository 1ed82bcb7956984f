// SPDX-License-Identifier: GPL-3.0-or-later
// GrazingEdge: the end of a family of orbits at a grazing of a hard contact. Families that share one are the same.
#pragma once

#include <graze/continuation/grazing.hpp>

#include <vector>

namespace graze {

struct GrazingEdge {
  double value = 0.0;  ///< of the continuation parameter
  int period = 0;
  int impacts = 0;  ///< of the family that ends there
  std::vector<Vector> states;
};

bool same_edge(const GrazingEdge& a, const GrazingEdge& b);

/// Without its weak impact an orbit may close after a divisor of its period: then that shorter orbit is the one beyond the
/// grazing. Shortens both and returns the period.
int to_least_period(PeriodicOrbit& orbit, LocatedGrazing& grazing);

}  // namespace graze
