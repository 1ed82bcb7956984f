// SPDX-License-Identifier: GPL-3.0-or-later
// BranchGraph: branches with their connections: the special point on which each branch was born, and a list of the tasks that
// were not followed.
//
// From its seeds the graph follows everything connected with them: doubled branches (and from a doubled branch the one on which
// it was born), branches that cross at a branch point, and the orbits beyond a grazing of a hard contact. The last are the
// orbits with one impact more or less, and up to max_multiple the families of m times their period that are born there, with
// the weak impact once in m turns or in all but one turn. (Families with the impact in other sets of turns are counted and
// listed as not followed.)
//
// Of two branches that are mirror images of each other (floquet/orbit/mirror.hpp) one is kept, and marked as mirrored. A family
// of orbits is kept once, independent of the way to it: a new branch is compared with the known ones, orbit by orbit and up to
// a shift in time.
//
// FamilyChoice restricts the branches that are followed and kept.
//
// Work is done in rounds of a fixed size, and the results of a round are accepted in order: the result does not depend on the
// number of threads.
#pragma once

#include <graze/continuation/graph/continuation.hpp>

namespace graze {

/// An orbit to start from, and the directions in which the parameter changes from it (+1, -1).
struct BranchSeed {
  PeriodicOrbit orbit;
  std::vector<int> directions = {1, -1};
};

/// The reason given for tasks that an interruption left undone.
inline constexpr const char* was_interrupted = "it was interrupted";

/// A special point at which orbits begin that were not followed; or, with branch 0, the number of tasks left out for one
/// reason. (Families of multiple periods beyond max_period or max_multiple exist at every grazing and are not listed.)
struct CutOff {
  int branch = 0;
  std::string label;
  std::string reason;
  int families = 0;  ///< number of families that begin there, if known
};

struct BranchGraph {
  std::vector<Branch> branches;
  std::vector<CutOff> cut_off;
  bool interrupted = false;
};

/// Choice of the families that are followed and kept.
struct FamilyChoice {
  /// If false, these branches are kept: branches that are stable somewhere, all of their ancestors, branches born where a
  /// stable stretch ends, and the family on the other side of a grazing that ends a stable stretch. The search for them is then
  /// limited by the members below.
  bool all = true;
  /// Branches beyond unstable orbits are followed until this many branches in a row were stable nowhere. (In the six shipped
  /// problems the longest such run that leads to a stable branch has 37.)
  int patience = 64;
  /// Orbits with more impacts in a forcing period, not counting complete chatters, are not followed: at low frequencies there
  /// are hundreds of families, each with one impact more than the last.
  int most_impacts = 32;
  /// On a branch narrower than this fraction of the range, the branches born on it are not visible. A doubled orbit with more
  /// than most_impacts_unseen impacts is then listed at its period doubling and not followed, because its cost grows with the
  /// square of the number of impacts.
  double narrowest = 1e-3;
  int most_impacts_unseen = 64;
};

/// Follows all branches from the seeds (converged orbits) within the range options.from ... options.to; without `from` it begins
/// at the first seed. `so_far`: branches of an earlier, interrupted run; they are kept, except those that were interrupted
/// themselves, and the missing ones are added. An interrupted run keeps all branches. Misuse throws std::invalid_argument.
BranchGraph follow_branches(const HybridSystem& system, const std::vector<BranchSeed>& seeds, const ContinuationOptions& options,
                            const std::vector<Branch>& so_far = {}, const FamilyChoice& choice = {});

/// True if the orbit with these states at phase 0 of its periods, at this value of the parameter, is on the branch, up to a
/// shift by forcing periods.
bool branch_contains(const HybridSystem& system, const Branch& branch, const std::vector<Vector>& states, double value);

}  // namespace graze
