// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/settle.hpp>
#include <graze/floquet/settling_orbit.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

/// A settled state returns this closely after one period of its orbit, relative to 1 + |x|; Newton decides, not this.
constexpr double worth_trying = 0.03;

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

}  // namespace

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

std::optional<PeriodicOrbit> orbit_of_close_returns(const HybridSystem& system, const Vector& p, const Vector& state,
                                                    int max_period, double nearness, const FlowOptions& flow) {
  constexpr std::size_t most_tries = 3;
  const Returns returns = close_returns(system, p, state, max_period, nearness, flow);
  for (std::size_t i = 0; i < std::min(most_tries, returns.periods.size()); ++i) {
    const int n = returns.periods[i];
    const std::vector<Vector> states(returns.states.begin(), returns.states.begin() + n);
    if (auto orbit = stable_orbit_near(system, p, states, n, flow)) return orbit;
  }
  return std::nullopt;
}

int ReturnWatch::see(const Vector& state) {
  ++periods_;
  int back = 0;
  if (looked_ >= 0 &&
      (state - looked_at_).lpNorm<Eigen::Infinity>() < recurrence_ * (1.0 + looked_at_.lpNorm<Eigen::Infinity>())) {
    back = periods_ - looked_;
    looked_ = -1;
    look_ = 2 * periods_;
  }
  if (periods_ == look_) {
    looked_ = periods_;
    looked_at_ = state;
    look_ = 2 * periods_;
  }
  return back;
}

}  // namespace graze
