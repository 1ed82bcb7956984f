// SPDX-License-Identifier: GPL-3.0-or-later
// Motions that are watched: carried one by one, or in lanes some forcing periods at a time, in a pool or all together, each until
// its watch is closed. A Watch has open(), state() (at forcing phase 0) and see(termination, state), which is told of every
// period while it is open; one that is carried side by side has skip(state, periods), too: whether so many periods, which lead to
// that state, need not be told one by one.
#pragma once

#include <graze/lib/lane_pool.hpp>

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

/// Forcing periods that are carried at a time, with so many behind. What is carried in vain where a watch is closed is half of
/// them on average: many are for those that last.
inline std::size_t next_stretch(std::size_t carried, std::size_t shortest) {
  return std::clamp(carried / (4 * shortest) * shortest, shortest, 8 * shortest);
}

/// The same in a pool.
template <class Watch, class Cancelled> LaneTask<bool> carry_watched(LanePlace& lane, Watch& watch, const Cancelled& cancelled) {
  std::size_t carried = 0;
  Vector state(2);
  while (watch.open()) {
    if (cancelled()) co_return false;
    const std::size_t stretch = next_stretch(carried, 4);
    carried += stretch;
    const std::span<const PeriodResult> periods = co_await lane.carry(watch.state(), stretch);
    for (const PeriodResult& period : periods) {
      if (!watch.open()) break;
      state << period.x, period.v;
      watch.see(period.termination, state);
    }
  }
  co_return true;
}

/// All together, at a parameter set of `many`. Ends when none is open (true) or `cancelled` says so (false).
template <class Watch, class Cancelled>
bool carry_side_by_side(ManyMotions& many, std::size_t set, std::vector<Watch>& watches, const Cancelled& cancelled) {
  constexpr std::size_t at_once = 2048;  // results that stay in the cache until they are seen
  std::size_t carried = 0;
  std::vector<MotionStart> motions;
  std::vector<PeriodResult> results;
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < watches.size(); ++i)
    if (watches[i].open()) open.push_back(i);
  Vector state(2);
  while (!cancelled()) {
    if (open.empty()) return true;
    const std::size_t stretch = next_stretch(carried, 4), together = at_once / stretch;  // of all motions, whatever the others do
    carried += stretch;
    for (std::size_t begin = 0; begin < open.size(); begin += together) {
      const std::size_t end = std::min(open.size(), begin + together);
      motions.clear();
      for (std::size_t k = begin; k < end; ++k) {
        const Vector& at = watches[open[k]].state();
        motions.push_back({set, at[0], at[1]});
      }
      many.carry(motions, stretch, false, results);
      const PeriodResult* next = results.data();
      for (std::size_t k = begin; k < end; ++k, next += stretch) {
        Watch& watch = watches[open[k]];
        state << next[stretch - 1].x, next[stretch - 1].v;
        if (next[stretch - 1].termination == Termination::time && watch.skip(state, static_cast<int>(stretch))) continue;
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
