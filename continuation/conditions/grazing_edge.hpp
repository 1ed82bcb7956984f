// SPDX-License-Identifier: GPL-3.0-or-later
// GrazingEdge: the end of a family of orbits at a grazing of a hard contact. It identifies the family: families with
// equal edges are the same.
#pragma once

#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/problems/special_point.hpp>

#include <vector>

namespace graze {

/// The grazing on which a branch ended.
struct GrazingEnd {
  LocatedGrazing grazing;
  bool lost = false;  ///< the branch has the impact; otherwise the orbits beyond gain it
};

struct GrazingEdge {
  double value = 0.0;          ///< of the continuation parameter
  int period = 0;              ///< forcing periods (PeriodicOrbit::period)
  int impacts = 0;             ///< of the family that ends there
  std::vector<Vector> states;  ///< of the grazing orbit, at phase 0 of its periods; empty if it could not be carried around
};

/// A family born on a grazing. Its orbits have `turns` times the period of the touching orbit, and the touch becomes an impact
/// in the first `struck` turns. {1, 0}: the touching orbit itself. {1, 1}: its partner with one impact more. {m, 1} and
/// {m, m - 1}: orbits of m times the period, with the weak impact in one turn, or in all but one.
struct TurnPattern {
  int turns = 1, struck = 1;
};

/// Whether period and impacts are equal, and the values and a state agree to 1e-9 (1 + |x|), with the unit of the parameter in
/// place of 1 for the values. False if a has no states.
bool same_edge(const GrazingEdge& a, const GrazingEdge& b, double unit);

/// The edge of a family with this number of impacts at the special point. `orbit` gives the period and the states.
GrazingEdge edge_at(const SpecialPoint& point, const PeriodicOrbit& orbit, int impacts);

/// Without its weak impact an orbit may close after a divisor of its period. The orbit beyond the grazing is then the shorter
/// one. Shortens orbit and grazing (`u` and `family_dp`) to the least period, and returns that period.
int to_least_period(PeriodicOrbit& orbit, LocatedGrazing& grazing);

/// The edge of the family beyond the grazing `point`. `lost`: the branch that ends there loses an impact. If the orbits of the
/// family are shorter, `grazing` is shortened too. Writes the grazing orbit to `orbit` unless it is null.
GrazingEdge partner_edge(const SpecialPoint& point, LocatedGrazing& grazing, bool lost, PeriodicOrbit* orbit = nullptr);

/// The edge of the touching orbit at the grazing `point`, the family {1, 0}. This family ends there, or begins there if an
/// impact is `lost`. `grazing` and `orbit`: see partner_edge.
GrazingEdge touching_edge(const SpecialPoint& point, LocatedGrazing& grazing, bool lost, PeriodicOrbit* orbit = nullptr);

/// The patterns {m, 1} and {m, m - 1} for m = 2 ... `turns`. If an impact is `lost`, {1, 1} is included, because the branch
/// that lost it may belong to another pattern.
std::vector<TurnPattern> patterns_up_to(int turns, bool lost);

/// The edge of the family with this pattern, from the edge of the touching orbit.
GrazingEdge pattern_edge(const GrazingEdge& touching, TurnPattern pattern);

}  // namespace graze
