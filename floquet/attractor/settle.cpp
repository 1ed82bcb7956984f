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
  const double T = forcing_period(system, p);
  Settled result;
  result.state = propagator.start(0.0, start).x;
  Transition transition;
  const auto next_period = [&] {
    if (options.cancelled && options.cancelled()) {
      result.termination = Termination::interrupted;
      return false;
    }
    carry(propagator, 0.0, T, result.state, {.sensitivity = Sensitivity::none}, transition);
    result.termination = transition.termination;
    if (transition.termination != Termination::time) return false;
    result.state = transition.x1;
    return true;
  };
  for (; result.periods < options.periods; ++result.periods) {
    if (next_period()) continue;
    // Ever lower bounces on a pressed stop that gives all energy back: they end in rest, but never.
    const auto rest = result.termination == Termination::event_limit ? rest_for_ever(propagator, result.state) : std::nullopt;
    if (!rest || !comes_to_rest(propagator, result.state, *rest)) return result;
    result.state = *rest;
    break;
  }
  if (result.periods > 0 && resonant_periods(system, p, result.state) > result.periods) {
    result.termination = Termination::resonance;
    return result;
  }
  // The state is handed on from before the look at its recurrence, so that the transient has just the length asked for.
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

SettledReturns settle_on_returns(const HybridSystem& system, const Vector& p, const Vector& start,
                                 const std::vector<std::size_t>& counted, int period, const SettleOptions& options,
                                 double longest_return) {
  if (counted.empty()) throw std::invalid_argument(fmt::format("system {} counts no event as a return", system.name));
  SettledReturns result;
  Propagator propagator(system, p, {}, options.flow);
  HybridState state = propagator.start(0.0, start);
  result.state = state.x;
  std::vector<double> times;
  std::vector<Vector> states;
  for (double last = 0.0; result.returns < options.periods + period + 1;) {
    if (options.cancelled && options.cancelled()) {
      result.termination = Termination::interrupted;
      return result;
    }
    const StepEnd end = propagator.step(state, last + longest_return, Sensitivity::none);
    if (end != StepEnd::event) return result;  // it failed, or does not return
    const auto& record = propagator.record();
    if (std::find(counted.begin(), counted.end(), record.event) == counted.end()) continue;
    last = record.t;
    times.push_back(record.t);
    states.push_back(record.x_plus);
    ++result.returns;
    result.state = record.x_plus;
  }
  result.termination = Termination::time;
  const auto before = times.size() - 1 - static_cast<std::size_t>(period);
  result.duration = times.back() - times[before];
  const double distance = (states.back() - states[before]).lpNorm<Eigen::Infinity>();
  result.repeats = distance < options.recurrence * (1.0 + states.back().lpNorm<Eigen::Infinity>());
  // Away from the return itself, at which a reset may make the state jump.
  const std::size_t previous = times.size() - 2;
  HybridState middle = propagator.start(times[previous], states[previous]);
  const double halfway = 0.5 * (times[previous] + times.back());
  while (propagator.step(middle, halfway, Sensitivity::none) == StepEnd::event) continue;
  result.state = middle.x;
  return result;
}

}  // namespace graze
