// SPDX-License-Identifier: GPL-3.0-or-later
// Carries motions until their observers (watches) close: one by one, in a pool, or all together (in lanes, several forcing
// periods at a time); autonomous motions from return to return. A Watch has open(), state() (at forcing phase 0) and
// see(termination, state), called after every period while it is open. A watch for carry_together also has skippable_periods():
// the number of next periods that it need not see unless they end in one of the ellipses known to the LaneCarrier; and
// leave_out(periods), which receives the number left out.
#pragma once

#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <limits>
#include <vector>

namespace graze {

/// Carries a motion period by period. `cancelled` is called before each. Ends when the watch closes (true) or on cancellation
/// (false).
template <class Watch, class Cancelled> bool carry_watched(Propagator& propagator, Watch& watch, const Cancelled& cancelled) {
  Transition transition;
  Vector state;
  while (watch.open()) {
    if (cancelled()) return false;
    state = watch.state();
    carry_period(propagator, state, {.sensitivity = Sensitivity::none}, transition);
    watch.see(transition.termination, transition.x1);
  }
  return true;
}

/// Number of forcing periods to carry next, after `carried` of them. On average half of them are wasted when the watch closes:
/// long batches are for motions that last.
inline std::size_t next_batch(std::size_t carried) {
  constexpr std::size_t shortest = 4;
  return std::clamp(carried / (4 * shortest) * shortest, shortest, 8 * shortest);
}

/// The same for the motion of a task, several periods at a time in lanes.
template <class Watch, class Cancelled> MotionTask<bool> carry_watched(TaskSlot& lane, Watch& watch, const Cancelled& cancelled) {
  std::size_t carried = 0;
  Vector state(watch.state().size());
  while (watch.open()) {
    if (cancelled()) co_return false;
    const std::size_t stretch = lane.batch(next_batch(carried));
    carried += stretch;
    const CarriedPeriods periods = co_await lane.carry(watch.state(), stretch);
    for (std::size_t k = 0; k < periods.size() && watch.open(); ++k) {
      periods.state(k, state);
      watch.see(periods.termination(k), state);
    }
  }
  co_return true;
}

/// Carries all motions together, at a parameter set of `many`. Ends when no watch is open (true) or on cancellation (false).
template <class Watch, class Cancelled>
bool carry_together(LaneCarrier& many, std::size_t set, std::vector<Watch>& watches, const Cancelled& cancelled) {
  struct Common {
    const Cancelled& cancelled;
    std::size_t seen = 0;
    bool stopped = false;
    Vector state = Vector(2);
  };
  struct One : PeriodObserver {
    Watch* watch = nullptr;
    Common* common = nullptr;
    std::size_t seen = 0;
    void expect() { next = seen + 1 + static_cast<std::size_t>(watch->skippable_periods()); }
  };
  constexpr std::size_t periods_between_cancellation_tests = 64;  // periods
  Common common{cancelled, 0, cancelled()};
  if (common.stopped) return false;
  std::vector<One> each(watches.size());
  std::vector<PeriodResult> last(watches.size());
  std::vector<MotionRun> runs;
  runs.reserve(watches.size());
  for (std::size_t i = 0; i < watches.size(); ++i) {
    each[i].see = [](PeriodObserver& self, std::size_t number, const PeriodResult& period) {
      One& one = static_cast<One&>(self);
      Common& all = *one.common;
      if (++all.seen % periods_between_cancellation_tests == 0) all.stopped = all.stopped || all.cancelled();
      if (all.stopped) return false;
      one.watch->leave_out(static_cast<int>(number - 1 - one.seen));
      one.seen = number;
      all.state << period.x, period.v;
      one.watch->see(period.termination, all.state);
      one.expect();
      return one.watch->open();
    };
    each[i].watch = &watches[i];
    each[i].common = &common;
    each[i].expect();
    const auto& start = watches[i].state();
    runs.push_back({.start = {set, start[0], start[1]},
                    .periods = std::numeric_limits<std::size_t>::max(),
                    .results = &last[i],
                    .watch = &each[i]});
  }
  many.carry(runs, false);
  return !common.stopped;
}

/// How the lanes carry watched motions, if they support the system.
struct WatchedInLanes {
  std::shared_ptr<const ContactTable> table = nullptr;  ///< of contacts at these parameters; may be null
  std::vector<StateEllipse> ellipses = {};              ///< see LaneCarrier::set_reported_ellipses
};

/// Carries all motions at these parameters: together in lanes or, if these do not support the system, one after another.
template <class Watch, class Cancelled>
void carry_all_watched(const SharedSystem& system, const Vector& p, const FlowOptions& flow, const WatchedInLanes& in_lanes,
                       std::vector<Watch>& watches, const Cancelled& cancelled) {
  const std::unique_ptr<LaneCarrier> many = make_lane_carrier(system, {&p, 1}, flow);
  if (!many) {
    Propagator propagator(system, p, {}, flow);
    for (Watch& watch : watches) carry_watched(propagator, watch, cancelled);
    return;
  }
  if (in_lanes.table) many->use(0, in_lanes.table);
  many->set_reported_ellipses(in_lanes.ellipses);
  carry_together(*many, 0, watches, cancelled);
}

}  // namespace graze
