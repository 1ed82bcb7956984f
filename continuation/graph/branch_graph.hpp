// SPDX-License-Identifier: GPL-3.0-or-later
// BranchGraph: branches and how they hang together: which was born on which special point, and what was left out.
//
// From its seeds everything is followed that hangs together with them: doubled branches (and back from a doubled branch to the
// one it was born on), branches that cross at a branch point, and the orbits beyond a grazing of a hard contact. Of two branches
// that are mirror images of each other (floquet/orbit/mirror.hpp) one is kept, and marked so. These are the orbits with one
// impact more or less, and up to max_multiple the families of m times their period that are born there: with the weak impact once
// in m turns, or in all but one of them. (Others, with the impact in some of the turns, are counted and listed as not followed.)
// A family of orbits is kept once, whichever way it was reached: a new branch is compared with those already there, orbit by
// orbit and up to a shift in time.
//
// FamilyChoice says how much of this is followed and kept.
//
// Work is done in rounds of a fixed size, and what a round brings is taken up in order: the result does not depend on the number
// of threads.
#pragma once

#include <graze/continuation/graph/continuation.hpp>

namespace graze {

/// An orbit to start from, and the directions in which the parameter changes from it (+1, -1).
struct BranchSeed {
  PeriodicOrbit orbit;
  std::vector<int> directions = {1, -1};
};

/// The reason of those that an interruption left over.
inline constexpr const char* was_interrupted = "it was interrupted";

/// A special point at which more orbits begin that were not followed. (That families of several times the period at a grazing end
/// at max_period and max_multiple holds for all of them and is not listed.) Or, with branch 0, all that were left out for a
/// reason.
struct CutOff {
  int branch = 0;
  std::string label;
  std::string reason;
  int families = 0;  ///< how many families begin there, where that is known
};

struct BranchGraph {
  std::vector<Branch> branches;
  std::vector<CutOff> cut_off;
  bool interrupted = false;
};

/// What is followed and kept.
struct FamilyChoice {
  /// False: kept are the branches that are stable somewhere, their parents (and theirs), what is born where a stable stretch
  /// ends, and the family on the other side of a grazing that ends one. And not all that may lead to more of them is followed:
  bool all = true;
  /// Branches that lie beyond unstable orbits are followed until this many branches in a row were stable nowhere. (In the six
  /// shipped problems the longest run that leads to a stable branch has 37.)
  int patience = 64;
  /// Orbits with more impacts in a forcing period, complete chatters not counted, are not followed: at low frequencies there are
  /// hundreds of families, each with one impact more than the last.
  int most_impacts = 32;
  /// A branch narrower than this part of the range hides the branches born on it. A doubled orbit with more than
  /// most_impacts_unseen impacts is then listed at its period doubling and not followed: its cost grows with the square of the
  /// number of impacts.
  double narrowest = 1e-3;
  int most_impacts_unseen = 64;
};

/// Follows everything from the seeds (converged orbits) within the range options.from ... options.to.
/// `so_far`: branches of an earlier run that was interrupted; they are kept (but for those that were broken off themselves), and
/// what is missing is added. One that is interrupted keeps all branches. Misuse throws std::invalid_argument.
BranchGraph follow_branches(const HybridSystem& system, const std::vector<BranchSeed>& seeds, const ContinuationOptions& options,
                            const std::vector<Branch>& so_far = {}, const FamilyChoice& choice = {});

/// True if the orbit with these states at phase 0 of its periods (at that value of the parameter) is one of the branch's, up to a
/// shift by forcing periods.
bool lies_on(const HybridSystem& system, const Branch& branch, const std::vector<Vector>& states, double value);

}  // namespace graze
