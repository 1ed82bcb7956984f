// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/own_coordinates.hpp>

namespace graze {

OwnCoordinates own_coordinates(const SpecialPoint& point, OrbitProblem& states) {
  const HybridSystem& system = states.system();
  OwnCoordinates own{std::nullopt, states.pack(point.orbit.nodes, point.orbit.duration, point.value)};
  if (!has_hard_contacts(system) || states.equations().autonomous()) return own;
  const std::optional<EventNodes> nodes = event_nodes(states.orbit(own.u));
  if (!nodes || impacts(system, {0, nodes->sequence}) != point.orbit.impacts) return own;
  own.by_events.emplace(states.system(), point.orbit.parameters, states.period(), nodes->sequence, states.free(),
                        states.equations().options());
  own.u = own.by_events->pack(*nodes, point.value);
  own.by_events->pin_as(states, own.u);
  return own;
}

namespace {

/// A point of the branch in these coordinates; empty if it cannot be expressed in them.
Vector in_coordinates(const OwnCoordinates& own, OrbitProblem& states, const BranchPoint& point) {
  OrbitProblem there = states.with_section(point.section_phase);
  if (there.nodes() != static_cast<int>(point.nodes.size())) return {};
  const Vector u = there.pack(point.nodes, point.duration, point.value);
  if (!own.by_events) return there.to_section(states, u).value_or(Vector{});
  const std::optional<EventNodes> nodes = event_nodes(there.orbit(u));
  if (!nodes || nodes->sequence != own.by_events->sequence()) return {};
  return own.by_events->pack(*nodes, point.value);
}

}  // namespace

Vector direction_along(const OwnCoordinates& own, OrbitProblem& states, const SpecialPoint& point, const Branch& branch) {
  const std::size_t k = point.after_point;
  Vector before, after;
  if (k < branch.points.size()) before = in_coordinates(own, states, branch.points[k]);
  if (k + 1 < branch.points.size()) after = in_coordinates(own, states, branch.points[k + 1]);
  if (before.size() == 0) before = own.u;
  if (after.size() == 0) after = own.u;
  return after - before;
}

}  // namespace graze
