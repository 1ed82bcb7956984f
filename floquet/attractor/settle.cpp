// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/motion/unbounded.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace graze {

Settled settle(const HybridSystem& system, const Vector& p, const Vector& start, const SettleOptions& options) {
  if (options.periods < 0)
    throw std::invalid_argument(fmt::format("settle is {} periods; allowed is 0 or more", options.periods));
  Propagator propagator(system, p, {}, options.flow);
  Settled result;
  result.state = propagator.start(0.0, start).x;
  Transition transition;
  const auto next_period = [&] {
    if (options.cancelled && options.cancelled()) {
      result.termination = Termination::interrupted;
      return false;
    }
    carry_period(propagator, result.state, {.sensitivity = Sensitivity::none}, transition);
    result.termination = transition.termination;
    if (transition.termination != Termination::time) return false;
    result.state = transition.x1;
    return true;
  };
  for (; result.periods < options.periods; ++result.periods) {
    if (next_period()) continue;
    // Ever lower bounces on a pressed stop without energy loss: the rest state is the limit, but is never reached.
    const auto rest = result.termination == Termination::event_limit ? permanent_rest(propagator, result.state) : std::nullopt;
    if (!rest || !reaches_rest(propagator, result.state, *rest)) return result;
    result.state = *rest;
    break;
  }
  if (result.periods > 0 && resonant_periods(system, p, result.state) > result.periods) {
    result.termination = Termination::resonance;
    return result;
  }
  // The result is the state before the test for recurrence, so that the transient has exactly the requested length.
  const Vector settled = result.state;
  result.termination = Termination::time;
  for (int n = 1; n <= options.max_period && result.suspected_period == 0; ++n) {
    if (!next_period()) return result;
    if ((result.state - settled).lpNorm<Eigen::Infinity>() < options.recurrence * (1.0 + settled.lpNorm<Eigen::Infinity>()))
      result.suspected_period = n;
  }
  result.state = settled;
  return result;
}

}  // namespace graze
