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

/// Where AttractorOptions::recurrence is set: returns that are worth Newton's method, against those that give rise to a look.
double nearness_of(const AttractorOptions& options) { return 20.0 * options.recurrence; }

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

/// The stable orbit of period n (or a divisor) that the motion through these states comes closer to.
std::optional<PeriodicOrbit> stable_orbit_near(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states,
                                               int n, const FlowOptions& flow) {
  const Vector& state = states.front();
  ShootingOptions shooting;
  shooting.flow = flow;
  PeriodicOrbit orbit = shoot(system, p, states, n, shooting);
  const double scale = 1.0 + state.lpNorm<Eigen::Infinity>();
  const bool near = orbit.converged() && distance(orbit, state) < 2.0 * worth_trying * scale;
  if (near && orbit.stable() && orbit.admissible == Admissibility::admissible && approaches(system, p, orbit, state, flow))
    return orbit;
  return std::nullopt;
}

/// The states that follow, and after how many periods the motion is back within `nearness`, the closest return first.
struct Returns {
  std::vector<Vector> states;
  std::vector<int> periods;
};

Returns close_returns(const HybridSystem& system, const Vector& p, const Vector& state, int max_period, double nearness,
                      const FlowOptions& flow) {
  constexpr double alike = 1e-10;  // returns this close are as good as each other: the shortest comes first
  Returns out{{state}, {}};
  Propagator propagator(system, p, {}, flow);
  const double T = forcing_period(system, p), scale = 1.0 + state.lpNorm<Eigen::Infinity>();
  Transition transition;
  std::vector<double> distances = {0.0};
  for (int n = 1; n <= max_period; ++n) {
    carry(propagator, 0.0, T, out.states.back(), {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination != Termination::time) break;
    distances.push_back(std::max(alike, (transition.x1 - state).lpNorm<Eigen::Infinity>() / scale));
    if (distances.back() < nearness) out.periods.push_back(n);
    out.states.push_back(transition.x1);
  }
  const auto closer = [&](int a, int b) {
    return distances[static_cast<std::size_t>(a)] < distances[static_cast<std::size_t>(b)];
  };
  std::stable_sort(out.periods.begin(), out.periods.end(), closer);
  return out;
}

/// settling_orbit where time matters: the few closest returns are tried, and only returns within `nearness`.
std::optional<PeriodicOrbit> orbit_of_close_returns(const HybridSystem& system, const Vector& p, const Vector& state,
                                                    int max_period, const AttractorOptions& options) {
  constexpr std::size_t most_tries = 3;
  const FlowOptions& flow = options.lyapunov.flow;
  const Returns returns = close_returns(system, p, state, max_period, nearness_of(options), flow);
  for (std::size_t i = 0; i < std::min(most_tries, returns.periods.size()); ++i) {
    const int n = returns.periods[i];
    const std::vector<Vector> states(returns.states.begin(), returns.states.begin() + n);
    if (auto orbit = stable_orbit_near(system, p, states, n, flow)) return orbit;
  }
  return std::nullopt;
}

/// The transient, with a look at every return to a state that moves on in doubling steps (Brent's way to find a cycle): most
/// motions are near their orbit long before the transient is over. Empty: none was recognised on the way.
std::optional<PeriodicOrbit> orbit_on_the_way(const HybridSystem& system, const Vector& p, const Vector& start,
                                              const AttractorOptions& options, Attractor& out) {
  constexpr int first_look = 4;
  const double T = forcing_period(system, p);
  Propagator propagator(system, p, {}, options.lyapunov.flow);
  Transition transition;
  out.state = propagator.start(0.0, start).x;
  out.termination = Termination::time;
  Vector looked_at;
  int look = first_look, looked = -1;
  for (int k = 1; k <= options.transient; ++k) {
    if (options.lyapunov.cancelled && options.lyapunov.cancelled()) {
      out.termination = Termination::interrupted;
      return std::nullopt;
    }
    carry(propagator, 0.0, T, out.state, {.sensitivity = Sensitivity::none}, transition);
    out.termination = transition.termination;
    if (transition.termination != Termination::time) return std::nullopt;
    out.state = transition.x1;
    if (looked >= 0) {
      const double scale = 1.0 + looked_at.lpNorm<Eigen::Infinity>();
      if ((out.state - looked_at).lpNorm<Eigen::Infinity>() < options.recurrence * scale) {
        if (auto orbit = orbit_of_close_returns(system, p, out.state, std::min(k - looked, options.max_period), options))
          return orbit;
        looked = -1;
        look = 2 * k;
      }
    }
    if (k == look) {
      looked = k;
      looked_at = out.state;
      look = 2 * k;
    }
  }
  return std::nullopt;
}

/// The orbit that is looked for at the end of a transient or an average.
std::optional<PeriodicOrbit> orbit_at_the_end(const HybridSystem& system, const Vector& p, const Vector& state,
                                              const AttractorOptions& options) {
  if (options.recurrence > 0.0) return orbit_of_close_returns(system, p, state, options.max_period, options);
  return settling_orbit(system, p, state, options.max_period, options.lyapunov.flow);
}

/// Whether the motion repeats itself, nearly and for long, without being known as periodic: it leaves a weakly unstable orbit, or
/// comes to a weakly stable one, and its average says nothing of where it ends. Chaos that happens to come back is soon away.
bool lingers(const HybridSystem& system, const Vector& p, const Attractor& attractor, const AttractorOptions& options) {
  if (attractor.type == AttractorType::periodic || attractor.termination != Termination::time) return false;
  constexpr int long_enough = 128;
  const FlowOptions& flow = options.lyapunov.flow;
  const double nearness = nearness_of(options);
  const Returns returns = close_returns(system, p, attractor.state, options.max_period, nearness, flow);
  if (returns.periods.empty()) return false;
  const auto n = static_cast<std::size_t>(returns.periods.front());
  Propagator propagator(system, p, {}, flow);
  Transition transition;
  std::vector<Vector> states(returns.states.begin(), returns.states.begin() + returns.periods.front() + 1);
  const double T = forcing_period(system, p), scale = 1.0 + attractor.state.lpNorm<Eigen::Infinity>();
  for (int k = 0; k < long_enough; ++k) {
    carry(propagator, 0.0, T, states.back(), {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination != Termination::time) return false;
    states.push_back(transition.x1);
    if ((states.back() - states[states.size() - 1 - n]).lpNorm<Eigen::Infinity>() > nearness * scale) return false;
  }
  return true;
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
  for (int n = 1; n <= max_period; ++n) {
    carry(propagator, 0.0, T, states.back(), {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination != Termination::time) return std::nullopt;
    const Vector next = transition.x1;
    if ((next - state).lpNorm<Eigen::Infinity>() < worth_trying * scale)
      if (auto orbit = stable_orbit_near(system, p, states, n, flow)) return orbit;
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
  if (options.recurrence > 0.0) {
    if (auto orbit = orbit_on_the_way(system, p, start, options, out)) {
      settle_on(out, std::move(*orbit));
      return out;
    }
  } else {
    SettleOptions settling;
    settling.periods = options.transient;
    settling.max_period = 0;
    settling.cancelled = options.lyapunov.cancelled;
    settling.flow = options.lyapunov.flow;
    const Settled settled = settle(system, p, start, settling);
    out.termination = settled.termination;
    out.state = settled.state;
  }
  if (out.termination != Termination::time) return out;
  if (auto orbit = orbit_at_the_end(system, p, out.state, options)) settle_on(out, std::move(*orbit));
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
    if (auto orbit = orbit_at_the_end(system, p, end, options)) return settle_on(attractor, std::move(*orbit));
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
  if (options.recurrence == 0.0) return out;
  AttractorOptions longer = options;
  constexpr int most_rounds = 3;
  for (int round = 0; lingers(system, p, out, options); ++round) {
    if (round == most_rounds) {
      out.type = AttractorType::undecided;
      break;
    }
    longer.transient = 3 * std::max(1, longer.transient);
    out = approach_attractor(system, p, out.state, longer);
    average_on_attractor(system, p, out, longer);
  }
  return out;
}

}  // namespace graze
