// SPDX-License-Identifier: GPL-3.0-or-later
// GrazingEdge: the end of a family of orbits at a grazing of a hard contact. Families that share one are the same.
#pragma once

#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/problems/special_point.hpp>

#include <vector>

namespace graze {

struct GrazingEdge {
  double value = 0.0;  ///< of the continuation parameter
  int period = 0;
  int impacts = 0;  ///< of the family that ends there
  std::vector<Vector> states;
};

/// Families born on a grazing, by the touches that become impacts: of `turns` turns of the orbit that touches, the first `struck`
/// ones. {1, 0}: that orbit itself; {1, 1}: its partner with one impact more; {m, 1} and {m, m - 1}: of m times its period, with
/// the weak impact once in m turns, or in all but one.
struct TurnPattern {
  int turns = 1, struck = 1;
};

bool same_edge(const GrazingEdge& a, const GrazingEdge& b);

GrazingEdge edge_at(const SpecialPoint& point, const PeriodicOrbit& orbit, int impacts);

/// Without its weak impact an orbit may close after a divisor of its period: then that shorter orbit is the one beyond the
/// grazing. Shortens both and returns the period.
int to_least_period(PeriodicOrbit& orbit, LocatedGrazing& grazing);

/// Of the family beyond the grazing `point`. Where its orbits are shorter, `grazing` (and the orbit written to `orbit`) are too.
GrazingEdge partner_edge(const SpecialPoint& point, LocatedGrazing& grazing, bool lost, PeriodicOrbit* orbit = nullptr);

/// Of the orbit that touches at the grazing `point`, the family {1, 0}: it ends there, or begins there if an impact is `lost`.
/// `grazing` and `orbit` as above.
GrazingEdge touching_edge(const SpecialPoint& point, LocatedGrazing& grazing, bool lost, PeriodicOrbit* orbit = nullptr);

/// {m, 1} and {m, m - 1} for m = 2 ... `turns`. Where an impact is `lost`, {1, 1} is among them: the branch that lost it may be
/// one of the others.
std::vector<TurnPattern> patterns_up_to(int turns, bool lost);

/// Of the family with that pattern, from the edge of the orbit that touches.
GrazingEdge pattern_edge(const GrazingEdge& touching, TurnPattern pattern);

}  // namespace graze
