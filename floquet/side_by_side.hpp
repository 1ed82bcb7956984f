// SPDX-License-Identifier: GPL-3.0-or-later
// Motions that are watched: carried side by side in lanes, some forcing periods at a time, or one by one, each until its watch is
// closed. A Watch has open(), state() (at forcing phase 0) and see(termination, state), which is told of every period while it is
// open.
#pragma once

#include <graze/lib/many_motions.hpp>

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
  constexpr std::size_t stretch = 8;  // what is carried in vain where a watch is closed is half of it on average
  std::vector<MotionStart> motions;
  std::vector<PeriodResult> results;
  while (!cancelled()) {
    motions.clear();
    for (std::size_t i = 0; i < watches.size(); ++i)
      if (watches[i].open()) motions.push_back({sets[i], watches[i].state()[0], watches[i].state()[1]});
    if (motions.empty()) return true;
    many.carry(motions, stretch, false, results);
    const PeriodResult* next = results.data();
    for (Watch& watch : watches) {
      if (!watch.open()) continue;
      for (std::size_t k = 0; k < stretch && watch.open(); ++k) watch.see(next[k].termination, Vector{{next[k].x, next[k].v}});
      next += stretch;
    }
  }
  return false;
}

/// A table of contacts of the speeds met from these starts (of one parameter set), kept by `scout`; null where none is made, or
/// where it does not pay for so many periods.
inline const ContactTable* scouted_table(ManyMotions& scout, const std::vector<MotionStart>& starts, std::int64_t expected) {
  if (starts.empty() || expected < ManyMotions::periods_for_table) return nullptr;
  constexpr std::size_t periods = 256;
  scout.expect(starts.front().parameters, expected);
  std::vector<PeriodResult> results;
  scout.carry(starts, periods, false, results);
  return scout.table(starts.front().parameters);
}

}  // namespace graze
