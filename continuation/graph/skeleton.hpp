// SPDX-License-Identifier: GPL-3.0-or-later
// Skeleton: every branch of periodic orbits in a range of one parameter that hangs together with a set of seeds, stable and
// unstable: the orbits without impact, the attractors of sweeps both ways and from rest, stable orbits found from many starts at
// values so close that a closed branch of a hundredth of the range is met, and unstable orbits found by global search.
#pragma once

#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/floquet/attractor/search.hpp>

#include <string>

namespace graze {

struct Skeleton;

struct SkeletonSeed {
  PeriodicOrbit orbit;
  std::string origin;  ///< "given", "settled" (sweeps and rest) or "searched"
  int part = -1;       ///< of the search for seeds, see Skeleton::searched; -1: given
};

struct SkeletonOptions {
  /// from, to: the range. max_period, max_branches and threads hold for the seeds too. max_multiple: see below.
  ContinuationOptions continuation = {};
  std::optional<Vector> start = {};  ///< from which attractors are looked for; none: rest
  int settled_values = 601;          ///< values of the parameter at which attractors are looked for, ends included
  int settle = 3200;  ///< forcing periods of transient at each, at most: one that returns close to itself is looked at before
  /// Values, ends included, at which stable orbits of every period are searched from many starts (StableSearchOptions::starts).
  int stable_values = 121;
  StableSearchOptions stable_search = {};
  FamilyChoice families = {};  ///< unstable orbits are searched if it is all
  int searched_values = 7;     ///< values, ends included, at which unstable orbits are searched
  int searched_period = 4;     ///< of period 1 up to this one
  SearchOptions search = {};
  /// See ContinuationOptions::max_multiple; 0: as far as max_period goes (none where that is not set).
  int max_multiple = 0;
  std::vector<PeriodicOrbit> more_seeds = {};  ///< the user's own
  std::vector<Branch> so_far = {};             ///< of an earlier run that was interrupted
  /// Of such a run too: Skeleton::seeds and Skeleton::searched. Parts that are done are not searched again.
  std::vector<SkeletonSeed> seeds_so_far = {};
  std::vector<char> searched_so_far = {};
  /// Told what is being done, and how much of it (0 to 1); by one thread at a time.
  std::function<void(const std::string& what, double part)> progress = {};
  /// Told whenever there is more to keep, with what gives the skeleton as it would be if it were interrupted now; likewise.
  std::function<void(const std::function<Skeleton()>& so_far)> keep = {};
};

/// The seeds alone: admissible orbits, in a fixed order, duplicates at one value left out. Those of an autonomous system are the
/// settled ones.
std::vector<SkeletonSeed> skeleton_seeds(const HybridSystem& system, const Vector& p, const SkeletonOptions& options);

/// How fine the search for seeds was.
struct SearchFineness {
  int values = 0;        ///< at which stable orbits were searched, up to `max_period`
  double spacing = 0.0;  ///< of these values
  int starts = 0;        ///< at each
  int max_period = 0;
  int unstable_values = 0, unstable_period = 0;  ///< the same of unstable orbits; 0: they were not searched
};

struct Skeleton {
  std::vector<SkeletonSeed> seeds;
  std::vector<char> searched;  ///< of each part of the search for seeds, in their order: whether it is done
  SearchFineness fineness;
  BranchGraph graph;
};

/// Seeds and all that hangs together with them. `p`: values of the other parameters.
Skeleton skeleton(const HybridSystem& system, const Vector& p, const SkeletonOptions& options);

}  // namespace graze
