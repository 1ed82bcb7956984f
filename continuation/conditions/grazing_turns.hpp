// SPDX-License-Identifier: GPL-3.0-or-later
// The orbits of several times the period that begin where a periodic orbit touches a barrier once in its period with a hard
// contact: how many there are, to first order in the speeds of their weak impacts.
//
// M carries a deviation over one turn, from touch to touch, c is the gradient of the guard there and k the change of state by an
// impact per unit of its speed. An orbit of m turns with impacts of speed v_j in the turns of a set I has its free maxima at
//     h_i = h_top + sum_{j in I} R_(i-j) v_j,   R_n = c . M^n z,  n = 1 ... m (mod m),   z = (1 - M^m)^{-1} k.
// It exists on the side h_top = 1 or -1 where v_j > 0 in I (with h_i = 0 there) and h_i < 0 in all other turns (Nordmark, J.
// Sound Vib. 145 (1991) 279, for the square-root map; here for any number of states).
#pragma once

#include <graze/continuation/conditions/grazing_edge.hpp>

namespace graze {

struct TurnResponse {
  Matrix turn;            ///< M
  Vector gradient, kick;  ///< c and k
};

/// Of the located grazing, one turn being the first `nodes` stretches of its equations from the touch on.
TurnResponse turn_response(const LocatedGrazing& grazing, int nodes);

/// Side of the family with impacts in the turns of `struck` (increasing, of `turns`): 1 beyond the grazing, -1 before it, 0 where
/// there is none.
int side_of_family(const TurnResponse& response, int turns, const std::vector<int>& struck);

/// Families of `turns` <= 16 turns with impacts in neither 1 nor all but one of them (nor all or none), each counted once
/// whichever turn it begins with; families of a divisor of so many turns do not count.
int families_in_some_turns(const TurnResponse& response, int turns);

/// All of these up to so many turns (16 at most); 0 where several contacts touch together.
int families_not_followed(const LocatedGrazing& grazing, int nodes, int longest);

/// That many, in words.
std::string others_text(int families, int longest);

}  // namespace graze
