// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/continuation.hpp>
#include <graze/continuation/orbit_problem.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

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
