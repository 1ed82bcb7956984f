// SPDX-License-Identifier: GPL-3.0-or-later
// Families of orbits with a multiple of the period that begin at a grazing of a hard contact: their number and their side, to
// first order in the speeds of their weak impacts. The grazing orbit touches the barrier once in its period.
//
// The n x n matrix M carries a deviation over one turn, from touch to touch. c is the gradient of the guard function at the
// touch, and k is the change of state by an impact per unit of its speed. Take an orbit of m turns with impacts of speed v_j in
// the turns of a set I. The free maxima of its turns are
//     h_i = h_top + sum_{j in I} R_(i-j) v_j,   R_n = c . M^n z,  n = 1 ... m (mod m),   z = (1 - M^m)^{-1} k.
// The orbit exists on the side h_top = 1 or h_top = -1 if there v_j > 0 and h_j = 0 for all turns of I, and h_i < 0 for all
// other turns (Nordmark, J. Sound Vib. 145 (1991) 279, for the square-root map; here for any number of states).
#pragma once

#include <graze/continuation/conditions/grazing_edge.hpp>

namespace graze {

struct TurnResponse {
  Matrix turn;            ///< M
  Vector gradient, kick;  ///< c and k
};

/// M, c and k of a located grazing. One turn consists of `nodes` stretches of its equations, from the touch on.
TurnResponse turn_response(const LocatedGrazing& grazing, int nodes);

/// Side of the family with impacts in the turns of `struck` (indices 0 ... turns - 1, increasing): 1 beyond the grazing,
/// where h_top > 0; -1 before it; 0 if the family does not exist.
int side_of_family(const TurnResponse& response, int turns, const std::vector<int>& struck);

/// Number of families of `turns` <= 16 turns with impacts in at least 2 and at most turns - 2 of them. A family is counted
/// once, independent of the turn with which it begins. Families that repeat after a divisor of `turns` are not counted.
int families_in_some_turns(const TurnResponse& response, int turns);

/// Sum of families_in_some_turns over 4 ... `longest` turns (at most 16). 0 if several contacts touch together.
int families_not_followed(const LocatedGrazing& grazing, int nodes, int longest);

/// A sentence on the result of families_not_followed, for the list of branches that were not followed.
std::string others_text(int families, int longest);

}  // namespace graze
