// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/least_period.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/floquet/orbit/state_distance.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// States immediately after the returns of an orbit.
std::vector<Vector> states_at_returns(const HybridSystem& system, const PeriodicOrbit& orbit) {
  const std::vector<std::size_t> returns = returns_of(system);
  std::vector<Vector> states;
  for (const EventRecord& event : orbit.events)
    if (std::find(returns.begin(), returns.end(), event.event) != returns.end()) states.push_back(event.x_plus);
  return states;
}

}  // namespace

std::optional<Midway> midway(Propagator& propagator, const Vector& state, int returns) {
  Transition transition;
  Vector at = state, begin = state;
  Midway out;
  double longest = -1.0, middle = 0.0;
  for (int k = 0; k < returns; ++k) {
    carry_period(propagator, at, {.sensitivity = Sensitivity::none, .keep_events = true}, transition);
    if (transition.termination != Termination::time) return std::nullopt;
    double last = 0.0;
    for (const EventRecord& event : transition.events) {
      if (event.t - last > longest) {
        longest = event.t - last;
        middle = 0.5 * (event.t + last);
        begin = at;
      }
      last = event.t;
    }
    out.duration += transition.duration;
    at = transition.x1;
  }
  std::optional<HybridState> flight = propagator.start_period(begin);
  while (propagator.step(*flight, middle, Sensitivity::none) == StepEnd::event) continue;
  out.state = flight->x;
  return out;
}

PeriodicOrbit shoot_returns(Propagator& propagator, const std::vector<Vector>& states, const ShootingOptions& options) {
  const HybridSystem& system = propagator.system();
  const Vector& p = propagator.parameters();
  const std::size_t n = states.size();
  const std::optional<Midway> begin = midway(propagator, states.front(), static_cast<int>(n));
  if (!begin || !mode_at(system, 0.0, begin->state, p)) return {};
  PeriodicOrbit orbit = shoot(system, p, std::vector<Vector>{begin->state}, 1, options, begin->duration);
  if (!orbit.converged()) return orbit;
  const std::vector<Vector> found = states_at_returns(system, orbit);
  constexpr double least = 1e-3;  // shorter: Newton's method has converged to a single state, an orbit of no duration
  if (found.empty() || orbit.duration < least * begin->duration) return {};
  const Vector& node = orbit.nodes.front();
  if (const auto mode = mode_at(system, 0.0, node, p)) {
    Vector field(node.size());
    propagator.field(*mode, 0.0, node, field);
    if (is_at_equilibrium(field, orbit.duration, node)) return {};
  }
  if (!options.reduce_period) return orbit;
  for (const std::size_t shorter : shorter_periods(found)) {
    // The states themselves: midway between two of them may not be on the guard.
    const std::vector<Vector> guess(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(shorter));
    PeriodicOrbit candidate = shoot_returns(propagator, guess, options);
    const std::vector<Vector> again = states_at_returns(system, candidate);
    if (!candidate.converged() || again.empty()) continue;
    // The shorter orbit may begin at another return. Times along the orbit are free, and its own multiplier 1 is no matter.
    std::vector<std::complex<double>> across = candidate.multipliers.values;
    across.resize(across.size() - std::min<std::size_t>(across.size(), static_cast<std::size_t>(candidate.multipliers.trivial)));
    const double distance = nearest_distance(found, again.front());
    if (is_repeated(across, found.size() / again.size(), distance, state_size(again.front()))) return candidate;
  }
  return orbit;
}

PeriodicOrbit at_returns(const HybridSystem& system, PeriodicOrbit orbit, const Vector& first) {
  if (!orbit.converged()) return orbit;
  orbit.states = states_at_returns(system, orbit);
  const auto nearest = std::min_element(orbit.states.begin(), orbit.states.end(), [&](const Vector& a, const Vector& b) {
    return state_distance(a, first) < state_distance(b, first);
  });
  std::rotate(orbit.states.begin(), nearest, orbit.states.end());
  orbit.state = orbit.states.front();
  orbit.period = static_cast<int>(orbit.states.size());
  return orbit;
}

int count_returns(const HybridSystem& system, const PeriodicOrbit& orbit) {
  return static_cast<int>(states_at_returns(system, orbit).size());
}

PeriodicOrbit at_nodes(PeriodicOrbit orbit) {
  if (orbit.multipliers.section != Section::autonomous) return orbit;
  orbit.period = 1;
  orbit.state = orbit.nodes.front();
  orbit.states = {orbit.state};
  return orbit;
}

}  // namespace graze
