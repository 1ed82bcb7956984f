// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/branch_end.hpp>
#include <graze/continuation/branch/follow_branch.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

Vector parameters_at(const HybridSystem& system, const Branch& branch, double value) {
  Vector p = branch.parameters;
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, branch.parameter))] = value;
  return p;
}

}  // namespace

bool releases_beyond(const HybridSystem& system, const Branch& branch, double value) {
  const BranchPoint& end = branch.points.back();
  if (!end.signature.events.empty() || !holds_something(system, end.signature.mode)) return false;
  Propagator propagator(system, parameters_at(system, branch, value));
  Transition transition;
  carry(propagator, 0.0, end.duration, end.states.front(), {.sensitivity = Sensitivity::none, .max_events = 1}, transition);
  return !transition.event_sequence.empty() && system.events[transition.event_sequence.front()].kind == EventKind::release;
}

OrbitProblem orbit_problem(const SharedSystem& system, const PeriodicOrbit& orbit, const ContinuationOptions& options, double low,
                           double high, int copies) {
  const double unit = parameter_unit(low, high), scale = std::max(high - low, 1e-6 * (unit + std::abs(high)));
  const std::size_t parameter = parameter_index(system->parameters, options.parameter);
  OrbitProblem problem(system, orbit.parameters, copies * orbit.period, copies * static_cast<int>(orbit.nodes.size()),
                       {{parameter, scale, unit}}, options.shooting.flow, orbit.section_phase);
  std::vector<Vector> nodes;
  for (int k = 0; k < copies; ++k) nodes.insert(nodes.end(), orbit.nodes.begin(), orbit.nodes.end());
  const double value = orbit.parameters[static_cast<Eigen::Index>(parameter)];
  problem.pin(problem.kept_states(problem.pack(nodes, copies * orbit.duration, value)));
  return problem;
}

std::optional<PeriodicOrbit> half_period_orbit(const HybridSystem& system, const Branch& branch,
                                               const ContinuationOptions& options) {
  const BranchPoint& last = branch.points.back();
  // The nodes stay clear of hard impacts, across which the two halves may differ by a jump.
  const std::size_t half = last.nodes.size() / 2;
  std::vector<Vector> guess;
  double apart = 0.0, scale = 1.0;
  for (std::size_t k = 0; k < half; ++k) {
    guess.push_back(0.5 * (last.nodes[k] + last.nodes[k + half]));
    apart = std::max(apart, (last.nodes[k] - last.nodes[k + half]).lpNorm<Eigen::Infinity>());
    scale = std::max(scale, 1.0 + guess.back().lpNorm<Eigen::Infinity>());
  }
  // Halves farther apart than a few of the longest steps have not met: the branch is a closed curve.
  constexpr double met = 0.2;
  if (half == 0 || apart > met * scale) return std::nullopt;
  OrbitProblem problem(system, parameters_at(system, branch, last.value), branch.period / 2, static_cast<int>(half),
                       parameter_index(system.parameters, branch.parameter), 1.0, options.shooting.flow, last.section_phase);
  Vector u = problem.pack(guess, 0.5 * last.duration, last.value);
  problem.pin(problem.kept_states(u));
  TraceOptions patient = options.trace;
  patient.max_iterations = options.shooting.max_iterations;
  const NewtonReport report = correct(problem.zero_problem(), problem.parameter_direction(), u, patient);
  if (!report.converged()) return std::nullopt;
  PeriodicOrbit orbit = problem.orbit(u, report);
  double moved = 0.0;
  for (std::size_t k = 0; k < half; ++k) moved = std::max(moved, (orbit.nodes[k] - guess[k]).lpNorm<Eigen::Infinity>());
  if (moved > apart || orbit.admissible != Admissibility::admissible) return std::nullopt;
  return orbit;
}

std::optional<GrazingEnd> relocate_grazing_end(const HybridSystem& system, const Branch& branch,
                                               const ContinuationOptions& options, double low, double high) {
  if (branch.stop != BranchStop::grazing) return std::nullopt;
  const SpecialPoint& point = branch.special_points.back();
  for (std::size_t back = 1; back <= 8 && back <= branch.points.size(); ++back) {
    const BranchPoint& last = branch.points[branch.points.size() - back];
    ShootingOptions shooting = options.shooting;
    shooting.reduce_period = false;
    const Vector p = parameters_at(system, branch, last.value);
    PeriodicOrbit orbit = is_forced(system)
                              ? shoot(system, p, last.states, branch.period, shooting)
                              : shoot(system, p, std::vector<Vector>{last.states.front()}, 1, shooting, last.duration);
    orbit.period = branch.period;
    if (!orbit.converged() || orbit.impacts != last.impacts) continue;
    OrbitProblem problem = orbit_problem(system, orbit, options, low, high);
    const Vector u = problem.pack(orbit.nodes, orbit.duration, last.value);
    const double direction = point.value >= last.value ? 1.0 : -1.0;
    Branch again;
    again.period = branch.period;
    again.parameter = branch.parameter;
    again.parameters = orbit.parameters;
    ContinuationOptions quiet = options;
    quiet.progress = nullptr;
    quiet.trace.initial_step = 1e-4;
    const FollowSettings settings(system, quiet, low, high);
    std::optional<GrazingEnd> end = follow_branch(settings, problem, {u, direction * problem.parameter_direction()}, again);
    if (end && std::abs(again.special_points.back().value - point.value) < 1e-9 * problem.size_of_value(point.value)) return end;
  }
  return std::nullopt;
}

bool is_partner(const Branch& child, const Branch& ended) {
  if (child.points.empty() || ended.points.empty()) return false;
  const SpecialPoint& point = ended.special_points.back();
  if (std::get<std::string>(point.details.at("kind")) == "gained") return child.period == ended.period;
  // Without its weak impact the orbit may close after a divisor of its period; families of a multiple of that period have the
  // impact.
  return ended.period % child.period == 0 &&
         child.points.front().impacts * (ended.period / child.period) < ended.points.back().impacts;
}

GrazingEdge first_edge(const SpecialPoint& point, const Branch& branch) {
  PeriodicOrbit at_grazing = point.orbit;
  at_grazing.period = branch.period;
  if (branch.period < point.orbit.period) at_grazing.states.resize(static_cast<std::size_t>(branch.period));
  return edge_at(point, at_grazing, branch.points.front().impacts);
}

const KnownEdge* partner_edge_among(const std::vector<KnownEdge>& edges, std::size_t index, const SpecialPoint& point,
                                    GrazingEnd end, double unit) {
  GrazingEdge partner = partner_edge(point, end.grazing, end.lost);
  // The partner has one impact more, or several if several contacts graze together.
  for (int more = 0; more < (end.lost ? 1 : max_simultaneous_contacts); ++more, ++partner.impacts)
    for (const KnownEdge& known : edges)
      if (known.branch != index && same_edge(known.edge, partner, unit)) return &known;
  return nullptr;
}

void set_scenario(Branch& branch, const std::function<void(SpecialPoint&)>& change) {
  SpecialPoint& point = branch.special_points.back();
  const auto name = [&] { return fmt::format("({})", std::get<std::string>(point.details.at("scenario"))); };
  const std::string before = name();
  change(point);
  if (const std::size_t at = branch.message.rfind(before); at != std::string::npos)
    branch.message.replace(at, before.size(), name());
}

void set_scenario_without_partner(Branch& branch, const std::string& reason, bool none) {
  if (is_smooth(branch.special_points.back())) return;
  set_scenario(branch, [&](SpecialPoint& point) {
    const std::string response = std::get<std::string>(point.details.at("scenario"));
    const bool says = response == grazing_scenario_name(GrazingScenario::persistence) ||
                      response == grazing_scenario_name(GrazingScenario::nonsmooth_fold);
    const GrazingScenario scenario = none ? GrazingScenario::none : GrazingScenario::undecided;
    if (none || !says) point.details.insert_or_assign("scenario", std::string(grazing_scenario_name(scenario)));
    point.details.insert_or_assign("scenario_from", none || !says ? reason : "linear response alone: " + reason);
  });
}

}  // namespace graze
