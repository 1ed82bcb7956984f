// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor.hpp>
#include <graze/floquet/lyapunov_lanes.hpp>
#include <graze/floquet/settle.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// A settled state returns this closely after one period of its orbit, relative to 1 + |x|; Newton decides, not this.
constexpr double worth_trying = 0.03;

/// Chaos is averaged over so many motions side by side, if the budget leaves each of them the longer part of it after parting.
constexpr int motions_in_chaos = 16;
constexpr std::int64_t budget_for_many = 4 * motions_in_chaos * parting;

/// Distance of a state to the nearest of an orbit's states at phase 0.
double distance(const PeriodicOrbit& orbit, const Vector& x) {
  double least = std::numeric_limits<double>::infinity();
  for (const Vector& state : orbit.states) least = std::min(least, (state - x).lpNorm<Eigen::Infinity>());
  return least;
}

/// True if the motion from x comes closer to the orbit: by half, in the time in which its slowest multiplier halves a distance.
bool approaches(const HybridSystem& system, const Vector& p, const PeriodicOrbit& orbit, const Vector& x,
                const FlowOptions& flow) {
  const double before = distance(orbit, x), slowest = std::abs(orbit.multipliers.values.front());
  constexpr double there = 1e-9, most = 20000.0;
  if (before < there) return true;
  const double turns = slowest > 0.0 ? std::ceil(std::log(0.5) / std::log(slowest)) : 1.0;
  SettleOptions options;
  options.periods = orbit.period * static_cast<int>(std::clamp(turns, 1.0, most / orbit.period));
  options.max_period = 0;
  options.flow = flow;
  const Settled later = settle(system, p, x, options);
  return later.termination == Termination::time && distance(orbit, later.state) < 0.75 * before;
}

}  // namespace

std::string_view attractor_type_name(AttractorType type) {
  switch (type) {
  case AttractorType::undecided:
    break;
  case AttractorType::periodic:
    return "periodic";
  case AttractorType::chaotic:
    return "chaotic";
  }
  return "undecided";
}

std::optional<PeriodicOrbit> settling_orbit(const HybridSystem& system, const Vector& p, const Vector& state, int max_period,
                                            const FlowOptions& flow) {
  Propagator propagator(system, p, {}, flow);
  const double T = forcing_period(system, p), scale = 1.0 + state.lpNorm<Eigen::Infinity>();
  std::vector<Vector> states{state};
  Transition transition;
  ShootingOptions shooting;
  shooting.flow = flow;
  for (int n = 1; n <= max_period; ++n) {
    carry(propagator, 0.0, T, states.back(), {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination != Termination::time) return std::nullopt;
    const Vector next = transition.x1;
    if ((next - state).lpNorm<Eigen::Infinity>() < worth_trying * scale) {
      PeriodicOrbit orbit = shoot(system, p, states, n, shooting);
      const bool near = orbit.converged() && distance(orbit, state) < 2.0 * worth_trying * scale;
      if (near && orbit.stable() && orbit.admissible == Admissibility::admissible && approaches(system, p, orbit, state, flow))
        return orbit;
    }
    states.push_back(next);
  }
  return std::nullopt;
}

void settle_on(Attractor& attractor, PeriodicOrbit orbit) {
  attractor.type = AttractorType::periodic;
  attractor.termination = Termination::time;
  attractor.period = orbit.period;
  attractor.impacts = orbit.impacts;
  attractor.state = orbit.state;
  attractor.exponents = orbit.multipliers.exponents;
  attractor.standard_errors.assign(attractor.exponents.size(), 0.0);
  attractor.orbit = std::move(orbit);
}

Attractor approach_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out;
  SettleOptions settling;
  settling.periods = options.transient;
  settling.max_period = 0;
  settling.cancelled = options.lyapunov.cancelled;
  settling.flow = options.lyapunov.flow;
  const Settled settled = settle(system, p, start, settling);
  out.termination = settled.termination;
  out.state = settled.state;
  if (settled.termination != Termination::time) return out;
  if (auto orbit = settling_orbit(system, p, settled.state, options.max_period, options.lyapunov.flow))
    settle_on(out, std::move(*orbit));
  return out;
}

void average_on_attractor(const HybridSystem& system, const Vector& p, Attractor& attractor, const AttractorOptions& options) {
  if (attractor.termination != Termination::time) return;
  LyapunovOptions averaging = options.lyapunov;
  if (attractor.type == AttractorType::periodic) {
    averaging.max_periods = std::min<std::int64_t>(averaging.max_periods, options.periods_on_orbit);
    if (averaging.max_periods >= averaging.interval)
      attractor.time_average = lyapunov_spectrum(system, p, attractor.state, averaging);
    return;
  }
  averaging.significance = options.significance;  // long enough to tell chaos, too
  if (averaging.change == 0.0 && averaging.max_periods >= budget_for_many)
    averaging.motions = std::max(averaging.motions, motions_in_chaos);
  attractor.time_average = lyapunov_spectrum(system, p, attractor.state, averaging);
  attractor.state = attractor.time_average.state;
  std::vector<Vector> ends = attractor.time_average.others;
  ends.insert(ends.begin(), attractor.state);
  for (const Vector& end : ends) {  // one that has settled tells that the chaos was transient
    if (auto orbit = settling_orbit(system, p, end, options.max_period, averaging.flow))
      return settle_on(attractor, std::move(*orbit));
    if (averaging.cancelled && averaging.cancelled()) return;
  }
  attractor.exponents = attractor.time_average.exponents;
  attractor.standard_errors = attractor.time_average.standard_errors;
  if (!attractor.exponents.empty() && attractor.exponents[0] > options.significance * attractor.standard_errors[0])
    attractor.type = AttractorType::chaotic;
}

Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out = approach_attractor(system, p, start, options);
  average_on_attractor(system, p, out, options);
  return out;
}

}  // namespace graze
