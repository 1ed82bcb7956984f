// SPDX-License-Identifier: GPL-3.0-or-later
// Periods: where the forcing periods of the motions in the lanes of a register begin and end, and these begin and end with them.
#pragma once

#include <graze/lib/lanes/memory.hpp>
#include <graze/lib/lanes/passage.hpp>
#include <graze/lib/lanes/queue.hpp>
#include <graze/lib/lanes/wide_registers.hpp>

#include <cmath>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

template <class Flight> class Periods {
  using Real = typename Flight::Real;
  static constexpr bool Tangent = Flight::tangent;
  static constexpr std::size_t W = width<Real>;

 public:
  using Jobs = Queue<2 * W>;  // for this one and another

  Periods(const Job& job, Jobs& queue) : job_(job), queue_(queue) {
    Starts starts;
    for (std::size_t lane = 0; lane < W; ++lane) next_motion(lane, starts);
    begin_motions(starts);
  }

  /// Lanes that have nothing to do take motions that have joined meanwhile.
  void take_more() {
    if (queue_.empty() || memory_.count(Task::idle) == 0) return;
    Starts starts;
    for_each(memory_.is(Task::idle), [&](std::size_t lane) { next_motion(lane, starts); });
    begin_motions(starts);
  }

 protected:
  /// Writes down what the periods did, and begins the next, from what is written: it is the same where another call goes on.
  /// Says which motions go on.
  Mask<Real> end_periods(const Mask<Real>& where, const Real& x, const Real& v) {
    Starts starts;
    const unsigned in_ellipse = queue_.watched() ? in_ellipses(x, v) : 0;
    unsigned goes_on = 0;
    alignas(64) double at[W], at_speed[W];
    put(at, x);
    put(at_speed, v);
    for_each(where, [&](std::size_t lane) {
      const Motion& motion = job_.motions[memory_.motion[lane]];
      Period& result = motion.result(memory_.period[lane]);
      result.x = at[lane];
      result.v = at_speed[lane];
      const bool told = motion.watch && interests(lane, motion, in_ellipse);
      const double impacts = memory_.field[impact_count][lane];
      if constexpr (Tangent) {
        for (std::size_t i = 0; i < 4; ++i) result.Phi[i] = memory_.field[phi_00 + i][lane];
        result.det = memory_.field[det][lane];
        const double of_impacts = impacts > 0.0 ? impacts * memory_.coefficient[rebound_volume][lane] : 0.0;
        result.liouville = memory_.field[divergence][lane] + of_impacts;
      }
      result.impacts = static_cast<std::int32_t>(impacts);
      result.termination = Termination::time;
      result.by_propagator = false;
      if (!may_go_on(lane, motion, result, told)) return end_motion(lane, starts, false);
      if (motion.notes) motion.notes->before = motion.notes->count;
      if (job_.law == Law::linear_elastic) load(lane, motion, at[lane]);
      goes_on |= 1U << lane;
    });
    const Mask<Real> on = mask_of<Real>(goes_on);
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
      const std::size_t period = memory_.period[lane];
      if (motion.notes) motion.notes->count = motion.notes->before;
      WideRegisters::leave();
      const bool done = job_.do_given_up && job_.do_given_up(job_.whom, job_, motion, period);
      if (!done) return end_motion(lane, starts, true);
      const Period& result = motion.result(period);
      if (!may_go_on(lane, motion, result, motion.watch != nullptr)) return end_motion(lane, starts, false);
      place(lane, motion, result.x, result.v, starts);
    });
    begin_motions(starts);
  }

  const Job& job_;
  Jobs& queue_;
  Memory<Real> memory_;

 private:
  /// Where motions begin.
  struct Starts {
    alignas(64) double x[W], v[W];
    unsigned there = 0;  // bit by bit
    Starts() {
      put(x, Real(0.0));
      put(v, Real(0.0));
    }
  };

  /// Whether the period that ends is one that the watch of its motion wants to be told of.
  bool interests(std::size_t lane, const Motion& motion, unsigned in_ellipse) const {
    return (in_ellipse >> lane & 1U) != 0 || memory_.period[lane] + 1 >= motion.watch->next;
  }

  /// Which of these states are in an ellipse of the job, bit by bit.
  unsigned in_ellipses(const Real& x, const Real& v) const {
    Mask<Real> in = mask_of<Real>(0);
    for (std::size_t i = 0; i < job_.ellipse_count; ++i) {
      const Ellipse& e = job_.ellipses[i];
      const Real d = x - e.x0, d_v = v - e.v0;
      in = in | (d * (e.xx * d + e.xv * d_v) + e.vv * (d_v * d_v) <= Real(1.0));
    }
    return bits(in);
  }

  void begin_motions(const Starts& starts) {
    begin_periods(mask_of<Real>(starts.there), take<Real>(starts.x), take<Real>(starts.v));
  }

  void begin_periods(Mask<Real> where, const Real& x, const Real& v) {
    memory_.set(impact_count, where, Real(0.0));
    if (job_.law == Law::restitution) {
      const Mask<Real> inside = where & (x > memory_[barrier]);
      memory_.assign(inside, Task::given_up);
      where = but_not(where, inside);
    }
    if constexpr (Tangent) memory_.begin_tangent(where);
    if (job_.law == Law::hertz) {
      const Real into = x - memory_[barrier];
      const Mask<Real> pressed = where & (into > Real(0.0));
      memory_.set(rest, pressed, memory_[period]);
      if (any(pressed)) touch(memory_, pressed, Real(sqrt(into)), v, Real(1.0), Real(0.0));
      where = but_not(where, pressed);
    }
    Flight::begin_period(memory_, where, x, v);
  }

  /// Puts the next motion, if there is one, in a lane.
  void next_motion(std::size_t lane, Starts& starts) {
    if (queue_.empty()) return memory_.assign(lane, Task::idle);
    memory_.motion[lane] = queue_.take();
    const Motion& motion = job_.motions[memory_.motion[lane]];
    memory_.period[lane] = 0;
    memory_.table[lane] = motion.table;
    memory_.met[lane] = motion.met;
    place(lane, motion, motion.x, motion.v, starts);
  }

  /// Lets the motion of a lane begin a period at (x, v).
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

  /// Whether a motion does, at the end of a period; its watch is told, and asked.
  bool may_go_on(std::size_t lane, const Motion& motion, const Period& result, bool told) {
    const std::size_t number = ++memory_.period[lane];
    const bool more = number != motion.periods && !queue_.stops(motion);
    if (!told) return more;
    WideRegisters::leave();
    return motion.watch->see(*motion.watch, number, result) && more;
  }

  void end_motion(std::size_t lane, Starts& starts, bool failed) {
    queue_.end(memory_.motion[lane], {memory_.period[lane], failed});
    // Whoever was told of it may have other coefficients in the same place now.
    if (job_.more) memory_.coefficients_of[lane] = nullptr;
    next_motion(lane, starts);
  }
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
