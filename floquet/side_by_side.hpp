// SPDX-License-Identifier: GPL-3.0-or-later
// Motions that are watched: carried side by side in lanes, some forcing periods at a time, or one by one, each until its watch is
// closed. A Watch has open(), state() (at forcing phase 0) and see(termination, state), which is told of every period while it is
// open.
#pragma once

#include <graze/lib/many_motions.hpp>

#include <algorithm>
#include <vector>

namespace graze {

/// Period by period; `cancelled` is asked before each. Ends when the watch is closed (true) or `cancelled` says so (false).
template <class Watch, class Cancelled> bool carry_watched(Propagator& propagator, Watch& watch, const Cancelled& cancelled) {
  const double T = forcing_period(propagator.system(), propagator.parameters());
  Transition transition;
  while (watch.open()) {
    if (cancelled()) return false;
    carry(propagator, 0.0, T, watch.state(), {.sensitivity = Sensitivity::none}, transition);
    watch.see(transition.termination, transition.x1);
  }
  return true;
}

/// sets[i] are the parameters of watches[i] in `many`. Ends when none is open (true) or `cancelled` says so (false).
template <class Watch, class Cancelled>
bool carry_side_by_side(ManyMotions& many, const std::vector<std::size_t>& sets, std::vector<Watch>& watches,
                        const Cancelled& cancelled) {
  // What is carried in vain where a watch is closed is half a stretch on average: long ones are for those that last. (All motions
  // take the same, so that what becomes of one does not depend on the others.)
  constexpr std::size_t shortest = 8, longest = 64, at_once = 2048;  // results that stay in the cache until they are seen
  std::size_t carried = 0;
  std::vector<MotionStart> motions;
  std::vector<PeriodResult> results;
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < watches.size(); ++i)
    if (watches[i].open()) open.push_back(i);
  Vector state(2);
  while (!cancelled()) {
    if (open.empty()) return true;
    const std::size_t stretch = std::clamp(carried / 32 * shortest, shortest, longest), together = at_once / stretch;
    carried += stretch;
    for (std::size_t begin = 0; begin < open.size(); begin += together) {
      const std::size_t end = std::min(open.size(), begin + together);
      motions.clear();
      for (std::size_t k = begin; k < end; ++k) {
        const Vector& at = watches[open[k]].state();
        motions.push_back({sets[open[k]], at[0], at[1]});
      }
      many.carry(motions, stretch, false, results);
      const PeriodResult* next = results.data();
      for (std::size_t k = begin; k < end; ++k, next += stretch) {
        Watch& watch = watches[open[k]];
        for (std::size_t period = 0; period < stretch && watch.open(); ++period) {
          state << next[period].x, next[period].v;
          watch.see(next[period].termination, state);
        }
      }
    }
    std::erase_if(open, [&](std::size_t i) { return !watches[i].open(); });
  }
  return false;
}

}  // namespace graze
