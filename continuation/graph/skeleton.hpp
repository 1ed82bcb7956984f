// SPDX-License-Identifier: GPL-3.0-or-later
// Skeleton: every branch of periodic orbits, stable and unstable, in a range of one parameter that is connected with a set of
// seeds. Seeds are the orbits without impact, the attractors of sweeps in both directions and from rest, stable orbits found
// from many starts, and unstable orbits found by global search. The values of the stable search are close enough to meet a
// closed branch that spans a hundredth of the range.
#pragma once

#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/floquet/attractor/search.hpp>

#include <string>

namespace graze {

struct Skeleton;

struct SkeletonSeed {
  PeriodicOrbit orbit;
  std::string origin;  ///< "given", "settled" (sweeps and rest) or "searched"
  int part = -1;       ///< part of the search for seeds (see Skeleton::searched); -1: given
};

struct SkeletonOptions {
  /// from, to: the range. max_period and threads hold for the seeds too. max_multiple: see below.
  ContinuationOptions continuation = {};
  std::optional<Vector> start = {};  ///< initial state of the search for attractors; none: rest
  int settled_values = 601;          ///< number of parameter values of the search for attractors, ends included
  int settle = 3200;                 ///< longest transient at each value (forcing periods); a close return ends it early
  /// Number of parameter values, ends included, of the search for stable orbits of every period from many starts
  /// (StableSearchOptions::starts).
  int stable_values = 121;
  StableSearchOptions stable_search = {};
  FamilyChoice families = {};  ///< unstable orbits are searched only if `all` is set
  int searched_values = 7;     ///< number of values, ends included, of the search for unstable orbits
  int searched_period = 4;     ///< longest period of that search, from 1
  SearchOptions search = {};
  /// See ContinuationOptions::max_multiple; 0: up to max_period (none if that is not set).
  int max_multiple = 0;
  std::vector<PeriodicOrbit> more_seeds = {};  ///< seeds given by the user
  std::vector<Branch> so_far = {};             ///< branches of an earlier, interrupted run
  /// Skeleton::seeds and Skeleton::searched of that run. Finished parts are not searched again.
  std::vector<SkeletonSeed> seeds_so_far = {};
  std::vector<char> searched_so_far = {};
  /// Observer of progress: the current work and its finished fraction (0 to 1). Called by one thread at a time.
  std::function<void(const std::string& what, double part)> progress = {};
  /// Called after new results, by one thread at a time; `so_far()` returns the skeleton that an interruption now would leave.
  std::function<void(const std::function<Skeleton()>& so_far)> keep = {};
};

/// The seeds alone: admissible orbits in a fixed order, without duplicates at the same parameter value. Seeds of an autonomous
/// system come from settling alone.
std::vector<SkeletonSeed> skeleton_seeds(const HybridSystem& system, const Vector& p, const SkeletonOptions& options);

/// Resolution of the search for seeds.
struct SearchFineness {
  int values = 0;        ///< number of parameter values of the search for stable orbits up to `max_period`
  double spacing = 0.0;  ///< of these values
  int starts = 0;        ///< number of starts at each value
  int max_period = 0;
  int unstable_values = 0, unstable_period = 0;  ///< the same for unstable orbits; 0: not searched
};

struct Skeleton {
  std::vector<SkeletonSeed> seeds;
  std::vector<char> searched;  ///< for each part of the search for seeds, in order: whether it is finished
  SearchFineness fineness;
  BranchGraph graph;
};

/// The seeds and all branches connected with them. `p`: values of the other parameters.
Skeleton skeleton(const HybridSystem& system, const Vector& p, const SkeletonOptions& options);

}  // namespace graze
