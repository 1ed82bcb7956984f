// SPDX-License-Identifier: GPL-3.0-or-later
// Carrier: steps the lanes of a register set through their tasks: a march far from the barrier, a step of flight near it, the
// end of a flight or of a period, a step of contact. It chooses the task that most lanes are at (choice.hpp). A lane whose
// motion has finished takes the next one. Lanes wait for each other only at tasks, not at the end of a period.
#pragma once

#include <graze/lib/lanes/choice.hpp>
#include <graze/lib/lanes/cubic_flight.hpp>
#include <graze/lib/lanes/periods.hpp>
#include <graze/lib/lanes/whole_contact.hpp>

#include <cmath>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

template <class Flight> class Carrier : public Periods<Flight> {
  using Real = typename Flight::Real;
  static constexpr bool Tangent = Flight::tangent;
  using Periods<Flight>::job_, Periods<Flight>::queue_, Periods<Flight>::memory_;
  using Periods<Flight>::end_periods, Periods<Flight>::give_up;

 public:
  Carrier(const Job& job, typename Periods<Flight>::Jobs& queue) : Periods<Flight>(job, queue) {
    if (job.law == Law::hertz) ratio_ = std::pow(job.tolerance, 1.0 / static_cast<double>(Flight::order));
  }

  Choice choice(bool alone = false) const { return choose(memory_, queue_.tables(), alone); }
  static bool waits(const Choice& choice) { return lanes::waits<Flight::cubic, Real>(choice); }

  /// One step of the lanes that are at a task.
  [[gnu::always_inline]] void step(Task task) {
    if (!Flight::cubic && (task == Task::marching || task == Task::flight))
      Flight::step(memory_, job_, task);  // no lane lands
    else
      end(task);
    if (memory_.count(Task::given_up) > 0) give_up();
  }

  /// Whether most contacts are carried in steps. One contact then takes as long as the rest of a period.
  bool steps_contacts() const { return job_.law == Law::hertz && !queue_.tables(); }
  void gather_contacts(Carrier& other) { lanes::gather_contacts(memory_, other.memory_); }

 private:
  /// One step of a task that may end something: a flight, a contact, a period.
  void end(Task task) {
    if (task == Task::contact) {
      const ContactEnd<Real> up = press<Flight>(memory_, job_, ratio_);
      if (any(up.at_barrier)) Flight::leave_barrier(memory_, up.at_barrier, up.v, up.c, up.s);
      if (any(up.at_end)) end_periods(up.at_end, Real(memory_[barrier] + up.y * up.y), up.v);
    } else if (task == Task::period_end) {
      end_in_flight();
    } else if (task != Task::idle && task != Task::given_up) {
      const Landing<Real> landing = Flight::step(memory_, job_, task);
      if (any(landing.where)) hit(landing);
      if (Flight::cubic && memory_.count(Task::period_end) > 0) end_in_flight();  // cheap beside a step by series
    }
    // Most lanes start a new flight here; march them together now rather than one by one later.
    if (!Flight::cubic && memory_.count(Task::marching) > 1) Flight::step(memory_, job_, Task::marching);
  }

  void hit(Landing<Real> landing) {
    landing.where = memory_.count_impacts(landing.where);
    if (queue_.notes()) record_impacts(memory_, landing, job_.motions);
    if (job_.law == Law::restitution) return rebound<Flight>(memory_, landing);
    if (job_.law == Law::linear_elastic) return change_sides<Flight>(memory_, landing, job_.motions);
    Mask<Real> touching = landing.where;
    if constexpr (!Flight::cubic) {  // tables exist for linear flights only
      if (queue_.met()) note_speeds(memory_, landing);
      if (queue_.tables()) touching = and_not(touching, pass_known(landing));
    }
    if (any(touching)) touch(memory_, touching, Real(0.0), landing.v, landing.c, landing.s);
  }

  /// Carries the contacts that the table covers.
  Mask<Real> pass_known(const Landing<Real>& landing) {
    const TabulatedContact<Real> contact = known_contact<Real, Tangent>(memory_, landing);
    if (any(contact.ends)) end_tabulated<Real, Tangent>(memory_, contact);
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

  double ratio_ = 1.0;
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
