// SPDX-License-Identifier: GPL-3.0-or-later
// BranchTask: a branch that is to be followed for a BranchGraph, where it begins, and what following it brought.
#pragma once

#include <graze/continuation/branch/branch_follower.hpp>
#include <graze/continuation/conditions/grazing_edge.hpp>

namespace graze {

enum class BranchOrigin { seed, doubled, crossing, beyond_grazing, multiple };

/// A branch to be followed.
struct BranchTask {
  BranchOrigin origin = BranchOrigin::seed;
  PeriodicOrbit orbit;                  ///< seed
  int direction = 1;                    ///< of a seed; of a crossing, its side
  std::size_t parent = 0, special = 0;  ///< the accepted branch and its special point
  int generation = 0;
  int seed = 0;              ///< number of the seed, from 1; 0: none. Both directions from a seed have the same.
  TurnPattern pattern = {};  ///< multiple
};

struct BranchOutcome {
  std::optional<Branch> branch;             ///< empty: nothing new begins there
  std::optional<GrazingEnd> grazing;        ///< on which it ended
  std::optional<PeriodicOrbit> half;        ///< the orbit of half the period to which it returned
  std::optional<GrazingEdge> begins, ends;  ///< at grazings
  std::string nothing;                      ///< why no orbit was found that should begin there
  bool none = false;                        ///< and there is none: it is not the grazing that was not found again
};

/// An end of a branch: its first point (`begins`) or its last one lies at a grazing.
struct KnownEdge {
  GrazingEdge edge;
  std::size_t branch = 0;
  bool begins = false;
};

}  // namespace graze
