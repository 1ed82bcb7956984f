// SPDX-License-Identifier: GPL-3.0-or-later
// Carrier: what the lanes of a register do, step by step: a march far from the barrier, a step of flight near it, the end of a
// flight or of a period, a step of contact, whichever most of them are at (choice.hpp). A lane that is through takes the next
// motion. Lanes do not wait for each other at the end of a period, only at these.
#pragma once

#include <graze/lib/lanes/choice.hpp>
#include <graze/lib/lanes/cubic_flight.hpp>
#include <graze/lib/lanes/passage.hpp>
#include <graze/lib/lanes/queue.hpp>
#include <graze/lib/lanes/whole_contact.hpp>
#include <graze/lib/lanes/wide_registers.hpp>

#include <cmath>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

template <class Flight> class Carrier {
  using Real = typename Flight::Real;
  static constexpr bool Tangent = Flight::tangent;

 public:
  using Jobs = Queue<2 * width<Real>>;  // for this one and another

  Carrier(const Job& job, Jobs& queue) : job_(job), queue_(queue) {
    if (job.law == Law::hertz) ratio_ = std::pow(job.tolerance, 1.0 / static_cast<double>(Flight::order));
    Starts starts;
    for (std::size_t lane = 0; lane < W; ++lane) next_motion(lane, starts);
    begin_periods(starts);
  }

  Choice choice(bool alone = false) const { return choose(memory_, queue_.tables(), alone); }
  static bool waits(const Choice& choice) { return lanes::waits<Flight::cubic, Real>(choice); }

  /// One step of the lanes that are at a task.
  void step(Task task) {
    if (task == Task::contact) {
      const Surfacing<Real> up = press<Flight>(memory_, job_, ratio_);
      if (any(up.at_barrier)) Flight::leave_barrier(memory_, up.at_barrier, up.v, up.c, up.s);
      if (any(up.at_end)) end_periods(up.at_end, Real(memory_[barrier] + up.y * up.y), up.v);
    } else if (task == Task::period_end) {
      end_in_flight();
    } else if (task != Task::idle && task != Task::given_up) {
      const Landing<Real> landing = Flight::step(memory_, job_, task);
      if (any(landing.where)) hit(landing);
      if (Flight::cubic && memory_.count(Task::period_end) > 0) end_in_flight();  // little beside a step by series
    }
    if (memory_.count(Task::given_up) > 0) give_up();
  }

  /// Lanes that have nothing to do take motions that have joined meanwhile.
  void take_more() {
    if (queue_.empty() || memory_.count(Task::idle) == 0) return;
    Starts starts;
    for_each(memory_.is(Task::idle), [&](std::size_t lane) { next_motion(lane, starts); });
    begin_periods(starts);
  }

  /// Whether contacts are carried in steps, most of them: so that one takes as long as all the rest of a period.
  bool steps_contacts() const { return job_.law == Law::hertz && !queue_.tables(); }
  void gather_contacts(Carrier& other) { lanes::gather_contacts(memory_, other.memory_); }

 private:
  static constexpr std::size_t W = width<Real>;

  /// Where the next periods of lanes begin; depth < 0: not in contact.
  struct Starts {
    alignas(64) double x[W] = {}, v[W] = {}, depth[W] = {};
    unsigned there = 0;  // bit by bit
  };

  void hit(Landing<Real> landing) {
    landing.where = memory_.count_impacts(landing.where);
    if (queue_.notes()) note_impacts(memory_, landing, job_.motions);
    if (job_.law == Law::restitution) return rebound<Flight>(memory_, landing);
    if (job_.law == Law::linear_elastic) return change_sides<Flight>(memory_, landing, job_.motions);
    Mask<Real> touching = landing.where;
    if constexpr (!Flight::cubic) {  // there are no tables of others
      if (queue_.met()) note_speeds(memory_, landing);
      if (queue_.tables()) touching = touching & !pass_known(landing);
    }
    if (any(touching)) touch(memory_, touching, Real(0.0), landing.v, landing.c, landing.s);
  }

  /// Contacts that the table knows.
  Mask<Real> pass_known(const Landing<Real>& landing) {
    const KnownContact<Real> contact = known_contact<Real, Tangent>(memory_, landing);
    if (any(contact.ends)) leave_known<Real, Tangent>(memory_, contact);
    if (any(contact.spans)) {
      const Real before = memory_[rest];
      begin_spanning<Real, Tangent>(memory_, contact);
      const Mask<Real> goes_on = end_periods(contact.spans, Real(memory_[barrier] + contact.y * contact.y), contact.v);
      if (any(goes_on)) end_spanning<Real, Tangent>(memory_, goes_on, contact, before);
    }
    return contact.ends | contact.spans;
  }

  void end_in_flight() {
    const Mask<Real> where = memory_.is(Task::period_end);
    const auto [x, v] = Flight::end(memory_, where);
    end_periods(where, x, v);
  }

  /// Writes down what the periods did, and begins the next, from what is written: it is the same where another call goes on.
  /// Says which motions go on.
  Mask<Real> end_periods(const Mask<Real>& where, const Real& x, const Real& v) {
    Starts starts;
    unsigned goes_on = 0;
    alignas(64) double at[W], at_speed[W];
    put(at, x);
    put(at_speed, v);
    for_each(where, [&](std::size_t lane) {
      const Motion& motion = job_.motions[memory_.motion[lane]];
      Period& result = motion.results[memory_.period[lane]];
      const int impacts = memory_.impacts[lane];
      result.x = at[lane];
      result.v = at_speed[lane];
      if constexpr (Tangent) {
        for (std::size_t i = 0; i < 4; ++i) result.Phi[i] = memory_.field[phi_00 + i][lane];
        result.det = memory_.field[det][lane];
        const double of_impacts = impacts > 0 ? impacts * memory_.coefficient[rebound_volume][lane] : 0.0;
        result.liouville = memory_.field[divergence][lane] + of_impacts;
      }
      result.impacts = impacts;
      result.termination = Termination::time;
      result.by_propagator = false;
      if (++memory_.period[lane] == motion.periods || queue_.stops(motion)) return end_motion(lane, starts, false);
      place(lane, motion, at[lane], at_speed[lane], starts);
      goes_on |= 1U << lane;
    });
    begin_periods(starts);
    return mask_of<Real>(goes_on);
  }

  void begin_periods(const Starts& starts) {
    const Mask<Real> where = mask_of<Real>(starts.there);
    const Real x = take<Real>(starts.x), v = take<Real>(starts.v), y = take<Real>(starts.depth);
    memory_.set(rest, where, memory_[period]);
    memory_.begin_tangent(where);
    const Mask<Real> pressed = where & (y >= Real(0.0));
    if (any(pressed)) touch(memory_, pressed, y, v, Real(1.0), Real(0.0));
    Flight::begin_period(memory_, where & !pressed, x, v);
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
    memory_.impacts[lane] = 0;
    if (motion.notes) motion.notes->before = motion.notes->count;
    const double into = x - (*motion.coefficients)[barrier];
    memory_.load(lane, motion, job_.law == Law::linear_elastic && into > 0.0);
    if (job_.law == Law::restitution && into > 0.0) return memory_.assign(lane, Task::given_up);
    starts.x[lane] = x;
    starts.v[lane] = v;
    starts.depth[lane] = job_.law == Law::hertz && into > 0.0 ? std::sqrt(into) : -1.0;
    starts.there |= 1U << lane;
  }

  void end_motion(std::size_t lane, Starts& starts, bool failed) {
    queue_.end(memory_.motion[lane], {memory_.period[lane], failed});
    // Whoever was told of it may have other coefficients in the same place now.
    if (job_.more) memory_.coefficients_of[lane] = nullptr;
    next_motion(lane, starts);
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
      if (++memory_.period[lane] == motion.periods || queue_.stops(motion)) return end_motion(lane, starts, false);
      place(lane, motion, motion.results[period].x, motion.results[period].v, starts);
    });
    begin_periods(starts);
  }

  const Job& job_;
  Jobs& queue_;
  double ratio_ = 1.0;
  Memory<Real> memory_;
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
