// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/orbit_shape.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/motion/transition.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace graze {

namespace {

/// Shape from `events` with times since phase 0; `unit`: length of a period.
OrbitShape from_events(const HybridSystem& system, const std::vector<EventRecord>& events, const std::vector<Vector>& states,
                       int period, double unit) {
  OrbitShape shape;
  shape.period = period;
  shape.autonomous = !is_forced(system);
  const auto is_stick = [](const EventRecord& event) {
    return event.kind == EventKind::stick || event.kind == EventKind::release;
  };
  shape.sticks = std::any_of(events.begin(), events.end(), is_stick);
  for (const EventRecord& event : events) {
    const bool node = shape.sticks ? event.kind == EventKind::release : !system.events[event.event].continuous;
    if (node) shape.nodes.push_back({event.event, event.t / unit, event.x_minus});
  }
  // An autonomous orbit has no natural start: without discontinuous events, its continuous events are the nodes.
  if (shape.nodes.empty() && shape.autonomous)
    for (const EventRecord& event : events) shape.nodes.push_back({event.event, event.t / unit, event.x_minus});
  if (!shape.nodes.empty()) return shape;
  for (std::size_t k = 0; k < states.size(); ++k)
    shape.nodes.push_back({system.events.size(), static_cast<double>(k), states[k]});
  return shape;
}

/// `b` from its node `first` on; empty if its events differ from those of `a`.
std::optional<AlignedShape> from_node(const OrbitShape& b, std::size_t first, const OrbitShape& a) {
  const std::size_t count = a.nodes.size();
  AlignedShape out{b, 0.0};
  for (std::size_t j = 0; j < count; ++j) {
    const std::size_t k = (j + first) % count;
    if (b.nodes[k].event != a.nodes[j].event) return std::nullopt;
    out.shape.nodes[j] = b.nodes[k];
    if (j + first >= count) out.shape.nodes[j].time += b.period;
  }
  const double later = out.shape.nodes.front().time - a.nodes.front().time;
  const double shift = a.autonomous ? later : std::round(later);
  for (std::size_t j = 0; j < count; ++j) {
    OrbitShape::Node& node = out.shape.nodes[j];
    node.time -= shift;
    const double states =
        (node.state - a.nodes[j].state).lpNorm<Eigen::Infinity>() / (1.0 + a.nodes[j].state.lpNorm<Eigen::Infinity>());
    out.distance = std::max({out.distance, 2.0 * std::numbers::pi * std::abs(node.time - a.nodes[j].time), states});
  }
  return out;
}

}  // namespace

OrbitShape shape_of(const HybridSystem& system, const PeriodicOrbit& orbit) {
  return from_events(system, orbit.events, orbit.states, orbit.period, orbit.duration / orbit.period);
}

OrbitShape shape_of(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states, double duration) {
  Propagator propagator(system, p);
  const double unit = duration / static_cast<double>(states.size());
  std::vector<EventRecord> events;
  Transition transition;
  for (std::size_t k = 0; k < states.size(); ++k) {
    carry(propagator, 0.0, unit, states[k], {.sensitivity = Sensitivity::none, .keep_events = true}, transition);
    if (transition.termination != Termination::time) return {};
    for (EventRecord& event : transition.events) {
      event.t += static_cast<double>(k) * unit;
      events.push_back(std::move(event));
    }
  }
  return from_events(system, events, states, static_cast<int>(states.size()), unit);
}

std::optional<AlignedShape> aligned(const OrbitShape& b, const OrbitShape& a) {
  if (a.period != b.period || a.nodes.size() != b.nodes.size() || a.nodes.empty() || a.sticks != b.sticks) return std::nullopt;
  std::optional<AlignedShape> nearest;
  for (std::size_t first = 0; first < b.nodes.size(); ++first) {
    std::optional<AlignedShape> here = from_node(b, first, a);
    if (here && (!nearest || here->distance < nearest->distance)) nearest = std::move(here);
  }
  return nearest;
}

bool same_orbit(const PeriodicOrbit& a, const PeriodicOrbit& b, double tolerance) {
  if (a.period != b.period) return false;
  const double scale = 1.0 + a.state.lpNorm<Eigen::Infinity>();
  if (std::any_of(b.states.begin(), b.states.end(),
                  [&](const Vector& x) { return (x - a.state).lpNorm<Eigen::Infinity>() < tolerance * scale; }))
    return true;
  const auto all_events = [](const PeriodicOrbit& orbit) {
    OrbitShape shape;
    shape.period = orbit.period;
    shape.autonomous = orbit.multipliers.section == Section::autonomous;
    for (const EventRecord& event : orbit.events)
      shape.nodes.push_back({event.event, event.t * orbit.period / orbit.duration, event.x_minus});
    return shape;
  };
  const std::optional<AlignedShape> other = aligned(all_events(b), all_events(a));
  return other && other->distance < tolerance;
}

bool same_but_place(const PeriodicOrbit& a, const PeriodicOrbit& b) {
  if (a.period != b.period) return false;
  const std::vector<KeptState> kept = kept_states(a.monodromy);
  if (kept.empty() || kept != kept_states(b.monodromy)) return false;
  Vector x = b.state;
  for (const KeptState& one : kept) one.set(x, one.of(a.state));
  return state_distance(x, a.state) < same_orbit_tolerance * (1.0 + state_size(x));
}

}  // namespace graze
