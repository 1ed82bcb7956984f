// SPDX-License-Identifier: GPL-3.0-or-later
// Periods: starts and ends the forcing periods, and with them the motions, in the lanes of a register set.
#pragma once

#include <graze/lib/lanes/memory.hpp>
#include <graze/lib/lanes/passage.hpp>
#include <graze/lib/lanes/period_result.hpp>
#include <graze/lib/lanes/queue.hpp>
#include <graze/lib/lanes/wide_registers.hpp>

#include <algorithm>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

template <class Flight> class Periods {
  using Real = typename Flight::Real;
  static constexpr bool Tangent = Flight::tangent;
  static constexpr std::size_t W = width<Real>;

 public:
  using Jobs = Queue<2 * W>;  // for two register sets

  Periods(const Job& job, Jobs& queue) : job_(job), queue_(queue) {
    Starts starts;
    for (std::size_t lane = 0; lane < W; ++lane) next_motion(lane, starts);
    begin_motions(starts);
  }

  /// Idle lanes take motions that have joined meanwhile.
  void take_more() {
    if (memory_.count(Task::idle) == 0 || queue_.empty()) return;
    Starts starts;
    for_each(memory_.is(Task::idle), [&](std::size_t lane) { next_motion(lane, starts); });
    begin_motions(starts);
  }

 protected:
  /// Stores the period's result if requested, and starts the next period from the stored values, so that splitting a run
  /// between calls changes nothing. Returns the motions that continue.
  Mask<Real> end_periods(const Mask<Real>& where, const Real& x, const Real& v) {
    Starts starts;
    const Real number = memory_[ended] + 1.0;
    memory_.set(ended, where, number);
    Mask<Real> on = where & (number < memory_[next_stored]), in_ellipse = mask_of<Real>(0);
    if (queue_.watched()) {
      in_ellipse = in_ellipses(job_, x, v);
      on = and_not(on, in_ellipse);
    }
    if (const Mask<Real> to_tell = and_not(where, on); any(to_tell)) on = on | store_results(to_tell, x, v, in_ellipse, starts);
    if (job_.law == Law::linear_elastic) {
      alignas(64) double at[W];
      put(at, x);
      for_each(on, [&](std::size_t lane) { load(lane, job_.motions[memory_.motion[lane]], at[lane]); });
    }
    if (starts.there == 0)
      begin_periods(on, x, v);
    else
      begin_periods(on | mask_of<Real>(starts.there), select(on, x, take<Real>(starts.x)), select(on, v, take<Real>(starts.v)));
    return on;
  }

  void give_up() {
    Starts starts;
    for_each(memory_.is(Task::given_up), [&](std::size_t lane) {
      const Motion& motion = job_.motions[memory_.motion[lane]];
      const std::size_t period = ended_in(lane);
      if (motion.notes) motion.notes->count = motion.notes->before;
      if (period > 0 && memory_.field[next_stored][lane] > 0.0) {  // the result of the period before may not be stored
        motion.result(period - 1).x = memory_.field[begun_at][lane];
        motion.result(period - 1).v = memory_.field[begun_with][lane];
      }
      WideRegisters::leave();
      const bool done = job_.carry_given_up && job_.carry_given_up(job_.whom, job_, motion, period);
      if (!done) return end_motion(lane, starts, true);
      memory_.field[ended][lane] += 1.0;
      const Period& result = motion.result(period);
      if (!continues(lane, motion, result, motion.watch != nullptr)) return end_motion(lane, starts, false);
      place(lane, motion, result.x, result.v, starts);
    });
    begin_motions(starts);
  }

  const Job& job_;
  Jobs& queue_;
  Memory<Real> memory_;

 private:
  /// Start states of motions.
  struct Starts {
    alignas(64) double x[W], v[W];
    unsigned there = 0;  // bits of the lanes
    Starts() {
      put(x, Real(0.0));
      put(v, Real(0.0));
    }
  };

  std::size_t ended_in(std::size_t lane) const { return static_cast<std::size_t>(memory_.field[ended][lane]); }

  /// Stores the results of the periods that have ended in these lanes. Returns the motions that continue.
  Mask<Real> store_results(const Mask<Real>& where, const Real& x, const Real& v, const Mask<Real>& in_ellipse, Starts& starts) {
    const unsigned interesting = bits(in_ellipse);
    unsigned goes_on = 0;
    alignas(64) double at[W], at_speed[W];
    put(at, x);
    put(at_speed, v);
    for_each(where, [&](std::size_t lane) {
      const Motion& motion = job_.motions[memory_.motion[lane]];
      const std::size_t number = ended_in(lane);
      Period& result = motion.result(number - 1);
      write_period<Real, Tangent>(memory_, lane, at[lane], at_speed[lane], result);
      const bool told = motion.watch && ((interesting >> lane & 1U) != 0 || number >= motion.watch->next);
      if (!continues(lane, motion, result, told)) return end_motion(lane, starts, false);
      if (motion.notes) motion.notes->before = motion.notes->count;
      goes_on |= 1U << lane;
    });
    return mask_of<Real>(goes_on);
  }

  void begin_motions(const Starts& starts) {
    begin_periods(mask_of<Real>(starts.there), take<Real>(starts.x), take<Real>(starts.v));
  }

  void begin_periods(Mask<Real> where, const Real& x, const Real& v) {
    memory_.set(impact_count, where, Real(0.0));
    if (queue_.watched()) {
      memory_.set(begun_at, where, x);
      memory_.set(begun_with, where, v);
    }
    if (job_.law == Law::restitution) {
      const Mask<Real> inside = where & (x > memory_[barrier]);
      memory_.assign(inside, Task::given_up);
      where = and_not(where, inside);
    }
    if constexpr (Tangent) memory_.begin_tangent(where);
    if (job_.law == Law::hertz) {
      const Real into = x - memory_[barrier];
      const Mask<Real> pressed = where & (into > Real(0.0));
      memory_.set(rest, pressed, memory_[period]);
      if (any(pressed)) touch(memory_, pressed, Real(sqrt(into)), v, Real(1.0), Real(0.0));
      where = and_not(where, pressed);
    }
    Flight::begin_period(memory_, where, x, v);
  }

  /// Puts the next motion, if there is one, in a lane.
  void next_motion(std::size_t lane, Starts& starts) {
    if (queue_.empty()) return memory_.assign(lane, Task::idle);
    memory_.motion[lane] = queue_.take();
    const Motion& motion = job_.motions[memory_.motion[lane]];
    memory_.field[ended][lane] = 0.0;
    listen(lane, motion);
    memory_.table[lane] = motion.table;
    memory_.met[lane] = motion.met;
    place(lane, motion, motion.x, motion.v, starts);
  }

  /// Starts a period of a lane's motion at (x, v).
  void place(std::size_t lane, const Motion& motion, double x, double v, Starts& starts) {
    if (motion.notes) motion.notes->before = motion.notes->count;
    load(lane, motion, x);
    starts.x[lane] = x;
    starts.v[lane] = v;
    starts.there |= 1U << lane;
  }
  void load(std::size_t lane, const Motion& motion, double x) {
    memory_.load(lane, motion, job_.law == Law::linear_elastic && x > (*motion.coefficients)[barrier]);
  }

  /// Whether a motion continues after a period. If `told`, its observer is called and decides too.
  bool continues(std::size_t lane, const Motion& motion, const Period& result, bool told) {
    const std::size_t number = ended_in(lane);
    const bool more = number != motion.periods && !queue_.stops(motion);
    if (!told) return more;
    WideRegisters::leave();
    if (!motion.watch->see(*motion.watch, number, result)) return false;
    listen(lane, motion);
    return more;
  }
  /// Sets which period of a motion must be stored next: without an observer, every one.
  void listen(std::size_t lane, const Motion& motion) {
    const bool some = motion.watch && !motion.notes && !job_.while_full;
    memory_.field[next_stored][lane] = some ? static_cast<double>(std::min(motion.watch->next, motion.periods)) : 0.0;
  }

  void end_motion(std::size_t lane, Starts& starts, bool failed) {
    queue_.end(memory_.motion[lane], {ended_in(lane), failed});
    // The callback may have put other coefficients in the same place.
    if (job_.more) memory_.coefficients_of[lane] = nullptr;
    next_motion(lane, starts);
  }
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
