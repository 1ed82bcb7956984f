// SPDX-License-Identifier: GPL-3.0-or-later
// BranchTask: a branch to be followed for a BranchGraph, with its start; BranchOutcome: the result of following it.
#pragma once

#include <graze/continuation/branch/branch_record.hpp>
#include <graze/continuation/conditions/grazing_families.hpp>

namespace graze {

/// `born`: at a special point (Birth). `grazing`: at the grazing on which a branch ended (GrazingFamily).
enum class BranchOrigin { seed, born, grazing };

/// A branch to be followed.
struct BranchTask {
  BranchOrigin origin = BranchOrigin::seed;
  PeriodicOrbit orbit;                  ///< start orbit of a seed
  int direction = 1;                    ///< seed: direction of the parameter; born: side of the special point
  std::size_t parent = 0, special = 0;  ///< places of the accepted branch and of its special point
  int generation = 0;
  int seed = 0;               ///< number of the seed, from 1 (the same for both directions); 0: none
  GrazingFamily family = {};  ///< at a grazing

  bool is(GrazingFamily::Kind kind) const { return origin == BranchOrigin::grazing && family.kind == kind; }
};

struct BranchOutcome {
  std::optional<Branch> branch;             ///< empty: no new branch begins there
  std::optional<GrazingEnd> grazing;        ///< at which it ended
  std::optional<PeriodicOrbit> half;        ///< orbit of half the period to which it returned
  std::optional<GrazingEdge> begins, ends;  ///< edges of the branch at grazings
  std::string nothing;                      ///< why no branch was found there, if that is to be reported
  bool none = false;                        ///< no orbit exists there (as opposed to: the grazing was not found again)
};

/// An end of a branch at a grazing: its first point (`begins`) or its last one.
struct KnownEdge {
  GrazingEdge edge;
  std::size_t branch = 0;
  bool begins = false;
};

}  // namespace graze
