// SPDX-License-Identifier: GPL-3.0-or-later
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
  for (std::size_t d = 1; options.reduce_period && d <= found.size() / 2; ++d) {
    constexpr double may_close = 1e-5, same_duration = 1e-6;
    if (found.size() % d != 0 || state_distance(found[d], found[0]) > may_close * (1.0 + state_size(found[0]))) continue;
    PeriodicOrbit shorter = shoot_returns(propagator, {found.begin(), found.begin() + static_cast<std::ptrdiff_t>(d)}, options);
    const std::size_t times = found.size() / d;
    if (shorter.converged() &&
        std::abs(static_cast<double>(times) * shorter.duration - orbit.duration) < same_duration * orbit.duration)
      return shorter;
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
