// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

#include <algorithm>
#include <complex>

namespace graze {

namespace {

/// Interpolates from a to b at s, node by node.
OrbitShape between(const OrbitShape& a, const OrbitShape& b, double s) {
  OrbitShape out = a;
  for (std::size_t k = 0; k < a.nodes.size(); ++k) {
    out.nodes[k].time += s * (b.nodes[k].time - a.nodes[k].time);
    out.nodes[k].state += s * (b.nodes[k].state - a.nodes[k].state);
  }
  return out;
}

/// More iterations than the tracer allows: the guess lies between two orbits, not next to one.
TraceOptions patient() {
  TraceOptions options;
  options.max_iterations = 20;
  return options;
}

/// Newton's method from states at equally spaced times, at the parameters p. Without forcing the duration changes too. False if
/// it fails.
bool correct_states(const HybridSystem& system, const Vector& p, int period, std::size_t parameter, std::vector<Vector>& states,
                    double& duration) {
  const int count = static_cast<int>(states.size());
  OrbitProblem problem(system, p, period, count, parameter, 1.0);
  Vector u = problem.pack(states, duration, p[static_cast<Eigen::Index>(parameter)]);
  if (problem.equations().autonomous()) problem.equations().set_phase_reference(states.front());
  problem.pin(problem.kept_states(u));
  if (!correct(problem.zero_problem(), problem.parameter_direction(), u, patient()).converged()) return false;
  for (int k = 0; k < count; ++k) states[static_cast<std::size_t>(k)] = problem.equations().node(u, k);
  duration = problem.equations().duration(u);
  return true;
}

/// The orbit near a guess, corrected in the coordinates of the guess; empty if that fails.
std::optional<OrbitShape> corrected(const HybridSystem& system, const Vector& p, std::size_t parameter, const OrbitShape& guess,
                                    double duration) {
  const double value = p[static_cast<Eigen::Index>(parameter)], unit = duration / guess.period;
  OrbitShape out = guess;
  if (guess.by_events(system)) {
    EventNodes nodes;
    for (const OrbitShape::Node& node : guess.nodes) {
      nodes.sequence.push_back(node.event);
      nodes.times.push_back(node.time * unit);
      nodes.states.push_back(node.state);
    }
    SignatureProblem problem(system, p, guess.period, nodes.sequence, parameter, 1.0);
    Vector u = problem.pack(nodes, value);
    problem.pin(problem.kept_states(u));
    if (!correct(problem.zero_problem(), problem.parameter_direction(), u, patient()).converged() || problem.violation(u))
      return std::nullopt;
    nodes = problem.unpack(u);
    for (std::size_t k = 0; k < out.nodes.size(); ++k) {
      out.nodes[k].time = nodes.times[k] / unit;
      out.nodes[k].state = nodes.states[k];
    }
    return out;
  }
  std::vector<Vector> states;
  for (const OrbitShape::Node& node : guess.nodes) states.push_back(node.state);
  if (!correct_states(system, p, guess.period, parameter, states, duration)) return std::nullopt;
  for (std::size_t k = 0; k < out.nodes.size(); ++k) out.nodes[k].state = states[k];
  return out;
}

/// The shape of a branch's point, with the nodes that shape_of gives: of contacts that lead through other modes, those that jump.
OrbitShape shape_of(const HybridSystem& system, const Vector& p, const BranchPoint& point) {
  const auto is_continuous = [&](const OrbitShape::Node& node) { return system.events[node.event].continuous; };
  OrbitShape shape = point.shape;
  if (shape.by_events(system) && !std::all_of(shape.nodes.begin(), shape.nodes.end(), is_continuous))
    std::erase_if(shape.nodes, is_continuous);
  return shape.nodes.empty() ? shape_of(system, p, point.states, point.duration) : shape;
}

/// Whether the nodes are all events of the orbit, so that they can be coordinates.
bool has_all_events(const HybridSystem& system, const OrbitShape& shape) {
  if (!shape.by_events(system)) return true;
  std::vector<std::size_t> events;
  for (const OrbitShape::Node& node : shape.nodes) events.push_back(node.event);
  return !first_break(system, events);
}

/// Converts the times of an autonomous orbit to units of its own duration: its number of returns is a convention.
OrbitShape in_own_duration(OrbitShape shape) {
  if (!shape.autonomous) return shape;
  for (OrbitShape::Node& node : shape.nodes) node.time /= shape.period;
  shape.period = 1;
  return shape;
}

/// The same from states between the events and from the duration, which is corrected without forcing: for an autonomous orbit,
/// for one that sticks, and for one some of whose events are not known.
std::optional<OrbitShape> corrected_in_states(const HybridSystem& system, const Vector& p, std::size_t parameter,
                                              std::vector<Vector> states, double& duration) {
  if (!correct_states(system, p, static_cast<int>(states.size()), parameter, states, duration)) return std::nullopt;
  return in_own_duration(shape_of(system, p, states, duration));
}

std::vector<Vector> between(const std::vector<Vector>& a, const std::vector<Vector>& b, double s) {
  std::vector<Vector> out = a;
  for (std::size_t k = 0; k < a.size(); ++k) out[k] += s * (b[k] - a[k]);
  return out;
}

/// Whether sticking determines the orbit: it forgets every disturbance.
bool forgets_all(const BranchPoint& point) {
  const std::vector<std::complex<double>> own = nontrivial(point.multipliers);
  return std::all_of(own.begin(), own.end(), [](std::complex<double> mu) { return mu == 0.0; });
}

}  // namespace

bool branch_contains(const HybridSystem& system, const Branch& branch, const std::vector<Vector>& states, double value) {
  if (is_forced(system) && states.size() != static_cast<std::size_t>(branch.period)) return false;
  const std::size_t parameter = parameter_index(system.parameters, branch.parameter);
  const auto at = [&](double v) {
    Vector p = branch.parameters;
    p[static_cast<Eigen::Index>(parameter)] = v;
    return p;
  };
  const auto shape = [&](const BranchPoint& point) { return in_own_duration(shape_of(system, at(point.value), point)); };
  std::optional<OrbitShape> here;
  for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) {
    const BranchPoint &a = branch.points[i], &b = branch.points[i + 1];
    if (a.value == b.value || value < std::min(a.value, b.value) || value > std::max(a.value, b.value)) continue;
    const double s = (value - a.value) / (b.value - a.value);
    double duration =
        is_forced(system) ? branch.period * forcing_period(system, at(value)) : a.duration + s * (b.duration - a.duration);
    // Without forcing the states do not determine the duration of the orbit; the branch does.
    const auto from_one_state = [&] { return shape_of(system, at(value), {states.front()}, duration); };
    if (!is_forced(system)) {
      here = from_one_state();
    } else if (!here) {
      here = shape_of(system, at(value), states, duration);
    }
    const OrbitShape first = shape(a);
    const std::optional<AlignedShape> second = aligned(shape(b), first);
    if (!second) continue;
    // Between two points the curve stays closer to its chord than half the chord's length; beyond this test Newton's method
    // decides.
    constexpr double rounding = 1e-6;
    const OrbitShape guess = between(first, second->shape, s);
    const std::optional<AlignedShape> orbit = aligned(*here, guess);
    if (!orbit || orbit->distance > 0.5 * second->distance + rounding) continue;
    if (guess.sticks && forgets_all(a) && forgets_all(b)) return true;
    const std::optional<OrbitShape> found =
        guess.autonomous || guess.sticks || !has_all_events(system, guess)
            ? corrected_in_states(system, at(value), parameter, between(a.states, b.states, s), duration)
            : corrected(system, at(value), parameter, guess, duration);
    if (!found) continue;
    if (guess.autonomous) here = from_one_state();
    const std::optional<AlignedShape> same = aligned(*found, guess.autonomous ? *here : orbit->shape);
    if (same && same->distance < rounding) return true;
  }
  return false;
}

}  // namespace graze
