// SPDX-License-Identifier: GPL-3.0-or-later
// A job in lanes. Those of two registers take turns where there are motions for them: each step waits for what the one before
// decided, and the processor has the other's to do meanwhile.
#pragma once

#include <graze/lib/lanes/carrier.hpp>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

template <class Flight> void carry_with(const Job& job) {
  std::size_t taken = 0;
  Carrier<Flight> first(job, taken);
  if (taken == job.count) {  // all are in its lanes
    while (first.step()) {
    }
    return;
  }
  Carrier<Flight> second(job, taken);
  for (bool goes_on = true; goes_on;) {
    goes_on = first.step();
    goes_on = second.step() || goes_on;
    first.gather_contacts(second);
  }
}

template <class Real> void carry(const Job& job) {
  if (job.cubic) return job.tangent ? carry_with<CubicFlight<Real, true>>(job) : carry_with<CubicFlight<Real, false>>(job);
  job.tangent ? carry_with<LinearFlight<Real, true>>(job) : carry_with<LinearFlight<Real, false>>(job);
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
