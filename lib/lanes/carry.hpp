// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a job in lanes. Two register sets are stepped alternately, if there are enough motions, so that one's dependent latency
// overlaps the other's work. A step of contact takes as long for few lanes as for all. Where contacts are carried in steps, the
// motions in contact are therefore gathered in one register set and the others in the other, and a set that is not full lets
// the other go first.
#pragma once

#include <graze/lib/lanes/carrier.hpp>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

template <class Flight> void interleave(Carrier<Flight>& first, Carrier<Flight>& second) {
  for (bool goes_on = true; goes_on;) {
    const Task one = first.choice().task;
    first.step(one);
    const Task two = second.choice().task;
    second.step(two);
    first.take_more();
    second.take_more();
    goes_on = one != Task::idle || two != Task::idle;
  }
}

template <class Flight> void sort_contacts(Carrier<Flight>& first, Carrier<Flight>& second) {
  for (;;) {
    const Choice one = first.choice(), two = second.choice();
    if (one.task == Task::idle && two.task == Task::idle) return;
    const bool first_waits = first.waits(one), second_waits = second.waits(two);
    const bool both_wait = first_waits && second_waits;  // then the fuller one goes
    if (!first_waits || (both_wait && one.lanes >= two.lanes)) first.step(one.task);
    if (!second_waits || (both_wait && one.lanes < two.lanes)) second.step(two.task);
    first.take_more();
    second.take_more();
    first.gather_contacts(second);
  }
}

template <class Flight> void carry_with(const Job& job) {
  typename Carrier<Flight>::Jobs queue(job);
  Carrier<Flight> first(job, queue);
  if (queue.empty()) {  // all motions are in its lanes
    for (Task task = first.choice(true).task; task != Task::idle; task = first.choice(true).task) {
      first.step(task);
      first.take_more();
    }
    return;
  }
  Carrier<Flight> second(job, queue);
  if (first.steps_contacts())
    sort_contacts(first, second);
  else
    interleave(first, second);
}

template <class Real, std::size_t Order> void carry_with_order(const Job& job) {
  if (job.cubic)
    return job.tangent ? carry_with<CubicFlight<Real, true, Order>>(job) : carry_with<CubicFlight<Real, false, Order>>(job);
  job.tangent ? carry_with<LinearFlight<Real, true, Order>>(job) : carry_with<LinearFlight<Real, false, Order>>(job);
}

template <class Real> void carry(const Job& job) {
  const WideRegisters until_the_end;
  job.tolerance < small_tolerance ? carry_with_order<Real, high_order>(job) : carry_with_order<Real, low_order>(job);
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
