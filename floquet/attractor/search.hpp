// SPDX-License-Identifier: GPL-3.0-or-later
// Global search for all orbits of period n in a box of states at forcing phase 0, unstable ones included.
//
// Starts are near returns of settled runs, local minima from NLopt (multi-level single linkage, MLSL, over |P^n(x) - x|^2),
// points of a low-discrepancy sequence over the box, and points beside the orbits found so far (orbits are born in pairs). A
// quick Newton iteration runs from each, in single or multiple shooting, with loose tolerances, and gives hopeless starts up
// early. shoot() then polishes new orbits. The search ends when `patience` consecutive starts have found nothing new.
// Duplicates (an orbit met at another of its n phases) and multiples of shorter orbits are dropped. The same seed gives the
// same result.
#pragma once

#include <graze/floquet/orbit/search_box.hpp>
#include <graze/floquet/orbit/shooting.hpp>

#include <functional>

namespace graze {

struct SearchOptions {
  Vector lower = {}, upper = {};  ///< the box; empty: search_box
  std::size_t max_steps = 0;      ///< SearchBox::max_steps of a given box; 0: as in shooting.flow
  unsigned seed = 1;
  int patience = 2000;  ///< starts without a new orbit after which the search ends
  int max_starts = 40000;
  bool all_threads = false;              ///< uses all threads of the caller's arena (oneTBB); the result is the same
  std::function<bool()> cancelled = {};  ///< called from several threads with all_threads; once true, it stays so
  std::function<void(int starts, int orbits)> progress = {};
  ShootingOptions shooting = {};
};

struct SearchResult {
  std::vector<PeriodicOrbit>
      orbits;             ///< by decreasing stability: stable first, then by largest multiplier; inadmissible ones marked
  int starts = 0;         ///< Newton iterations started
  int converged = 0;      ///< Newton iterations that converged to an orbit of the period or a divisor
  bool complete = false;  ///< ended by patience, not by max_starts or cancellation
  Termination ended = Termination::time;  ///< SearchBox::ended; if it is not time, nothing was searched
};

/// Start of a motion, with its parameters.
struct MotionFrom {
  Vector p, state;
};

struct SettlingOptions {
  int max_period = 64;
  int periods = 300;         ///< forcing periods after which a motion that has not settled is abandoned
  bool all_threads = false;  ///< as in SearchOptions
  std::function<bool()> cancelled = {};
  ShootingOptions shooting = {};
};

/// The stable admissible orbits on which these motions settle, each once, in the order of the motions. The motions are tasks
/// of a pool. Starts beyond a barrier are left out.
std::vector<PeriodicOrbit> settled_orbits(const HybridSystem& system, const std::vector<MotionFrom>& starts,
                                          const SettlingOptions& options = {});

struct StableSearchOptions {
  Vector lower = {}, upper = {};  ///< the box; empty: union of search_box at the first and last value
  int starts =
      128;  ///< at each value. An orbit whose basin has the share s of the box is missed with probability (1 - s)^starts.
  int box_periods = 300;  ///< of search_box
  unsigned seed = 1;
  SettlingOptions settling = {};
};

/// The stable orbits at each of these parameter sets, from starts spread evenly over the box (different ones for each set), at
/// a small part of the cost of search_orbits. @throws std::invalid_argument as search_orbits does.
std::vector<PeriodicOrbit> search_stable_orbits(const HybridSystem& system, const std::vector<Vector>& parameters,
                                                const StableSearchOptions& options = {});

/// All orbits of least period `period` found in the box. @throws std::invalid_argument for an empty box or an autonomous system.
SearchResult search_orbits(const HybridSystem& system, const Vector& p, int period, const SearchOptions& options = {});

}  // namespace graze
