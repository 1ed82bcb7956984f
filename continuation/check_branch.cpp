// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch_graph.hpp>
#include <graze/continuation/orbit_problem.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// How far two points of a branch can be apart at the most, per unit of arclength, with room for what the norm leaves out.
constexpr double speed_limit = 4.0;

/// Largest difference of the nodes; nothing where they lie at different phases.
std::optional<double> distance(const BranchPoint& a, const BranchPoint& b) {
  if (a.section_phase != b.section_phase || a.nodes.size() != b.nodes.size()) return std::nullopt;
  double largest = 0.0;
  for (std::size_t j = 0; j < a.nodes.size(); ++j)
    largest = std::max(largest, (a.nodes[j] - b.nodes[j]).lpNorm<Eigen::Infinity>());
  return largest;
}

/// A step that is longer than its arclength has jumped to another branch. (A hard impact that passes a node makes a jump of its
/// own, which is no such thing: nodes of hard systems keep clear of them.)
void find_jumps(const Branch& branch, const auto& violated) {
  for (std::size_t k = 1; k < branch.points.size(); ++k) {
    const BranchPoint &a = branch.points[k - 1], &b = branch.points[k];
    const double allowed = speed_limit * std::sqrt(static_cast<double>(b.nodes.size())) * (b.arclength - a.arclength) + 1e-9;
    const std::optional<double> moved = distance(a, b);
    if (moved && *moved > allowed)
      violated(fmt::format("it jumps between points {} and {}: by {:.3g}, where {:.3g} is the most", k - 1, k, *moved, allowed));
  }
}

/// A branch that meets orbits of its own again, shifted in time, runs back along itself (a doubled branch that missed its parent).
void find_retraces(const HybridSystem& system, const Branch& branch, const auto& violated) {
  constexpr std::size_t samples = 8, apart = 3;
  const std::size_t size = branch.points.size();
  for (std::size_t sample = 1; sample < samples; ++sample) {
    const std::size_t k = size * sample / samples;
    if (k < apart + 2) continue;
    Branch earlier;
    earlier.period = branch.period;
    earlier.parameter = branch.parameter;
    earlier.parameters = branch.parameters;
    earlier.points.assign(branch.points.begin(), branch.points.begin() + static_cast<std::ptrdiff_t>(k - apart));
    PeriodicOrbit orbit;
    orbit.period = branch.period;
    orbit.state = branch.points[k].state();
    orbit.states = branch.points[k].states;
    if (lies_on(system, earlier, orbit, branch.points[k].value))
      violated(fmt::format("point {} is an orbit that the branch has met before", k));
  }
}

}  // namespace

std::vector<std::string> check_branch(const HybridSystem& system, const Branch& branch) {
  std::vector<std::string> violations;
  const auto violated = [&](std::string sentence) { violations.push_back(fmt::format("branch {}: {}", branch.id, sentence)); };
  if (branch.points.empty()) return violations;
  const std::size_t parameter = parameter_index(system.parameters, branch.parameter);
  const auto problem_of = [&](const BranchPoint& point) {
    return OrbitProblem(system, branch.parameters, branch.period, static_cast<int>(point.nodes.size()), parameter, 1.0, {},
                        point.section_phase);
  };
  OrbitProblem problem = problem_of(branch.points.front());
  for (std::size_t k = 0; k < branch.points.size(); ++k) {
    const BranchPoint& point = branch.points[k];
    if (point.section_phase != problem.equations().section_phase()) problem = problem_of(point);
    const BranchPoint again = problem.branch_point(problem.pack(point.nodes, point.duration, point.value), point.arclength);
    // The state after a weak impact is known to its rounding over the impact's speed.
    double weakest = 1.0;
    for (const EventRecord& event : problem.orbit(problem.pack(point.nodes, point.duration, point.value), {}).events)
      if (event.kind == EventKind::impact) weakest = std::min(weakest, event.normal_speed);
    if (!(again.checks.residual >= 0.0 && again.checks.residual < 1e-11 + 1e-14 / weakest))
      violated(fmt::format("point {} leaves a residual of {:.3g}", k, again.checks.residual));
    if (again.stable != point.stable)
      violated(fmt::format("point {} is stored as {}stable and is not", k, point.stable ? "" : "un"));
    if (again.signature != point.signature) violated(fmt::format("point {} has another signature than stored", k));
    if (k > 0 && !(point.arclength > branch.points[k - 1].arclength))
      violated(fmt::format("arclength does not grow at point {}", k));
  }
  find_jumps(branch, violated);
  find_retraces(system, branch, violated);
  for (const SpecialPoint& special : branch.special_points) {
    if (!(special.interval[0] <= special.value && special.value <= special.interval[1]))
      violated(fmt::format("{} lies outside its interval", special.label));
    const bool changes_stability =
        special.type == PointType::LP || special.type == PointType::PD || special.type == PointType::NS;
    if (!changes_stability) continue;
    if (special.after_point + 1 >= branch.points.size()) {
      violated(fmt::format("{} lies beyond the last point", special.label));
      continue;
    }
    // Points of several types within one step may cancel in the count: then it says nothing.
    const auto same_step =
        std::count_if(branch.special_points.begin(), branch.special_points.end(), [&](const SpecialPoint& other) {
          return other.after_point == special.after_point && other.type != PointType::EP && other.type != PointType::UZ;
        });
    const BranchPoint &before = branch.points[special.after_point], &after = branch.points[special.after_point + 1];
    if (same_step == 1 && before.multipliers.unstable() == after.multipliers.unstable())
      violated(fmt::format("the number of unstable multipliers does not change across {}", special.label));
  }
  return violations;
}

}  // namespace graze
