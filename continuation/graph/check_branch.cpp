// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/signature_follower.hpp>
#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// The chord from one point to the next, nodes and parameter, in the measure of the arclength; empty if the nodes lie at other
/// phases.
Vector chord(const BranchPoint& a, const BranchPoint& b, double scale) {
  if (a.section_phase != b.section_phase || a.nodes.size() != b.nodes.size()) return {};
  const auto count = std::ssize(a.nodes);
  const Eigen::Index n = a.state().size();
  Vector out(count * n + 1);
  for (std::ptrdiff_t j = 0; j < count; ++j)
    out.segment(j * n, n) = (b.nodes[static_cast<std::size_t>(j)] - a.nodes[static_cast<std::size_t>(j)]) / std::sqrt(count);
  out[count * n] = (b.value - a.value) / scale;
  return out;
}

/// Detects jumps to a nearby branch, which show as corners. The tracer turns by at most 0.3 from one tangent to the next. At
/// folds (in the measure used here), branch points and grazings a branch may have a corner of its own, and so may the curve of
/// states at fixed phases where an impact is weak.
void find_jumps(const Branch& branch, const auto& violated) {
  constexpr double sharpest = 1.2, steep = 100.0;
  const auto [low, high] = std::minmax_element(branch.points.begin(), branch.points.end(),
                                               [](const BranchPoint& a, const BranchPoint& b) { return a.value < b.value; });
  const double scale = std::max(high->value - low->value, 1e-300);
  const auto may_turn = [&](std::size_t k) {
    return std::any_of(branch.special_points.begin(), branch.special_points.end(), [&](const SpecialPoint& point) {
      const bool may_have_corner = point.type == PointType::GR || point.type == PointType::LP || point.type == PointType::BP;
      return may_have_corner && (point.after_point == k || point.after_point + 1 == k);
    });
  };
  for (std::size_t k = 1; k + 1 < branch.points.size(); ++k) {
    const Vector before = chord(branch.points[k - 1], branch.points[k], scale);
    const Vector after = chord(branch.points[k], branch.points[k + 1], scale);
    if (before.size() == 0 || after.size() != before.size() || before.norm() * after.norm() == 0.0 || may_turn(k)) continue;
    const double largest = std::abs(nontrivial(branch.points[k].multipliers).front());
    if (largest > steep) continue;
    const double angle = std::acos(std::clamp(before.dot(after) / (before.norm() * after.norm()), -1.0, 1.0));
    if (angle > sharpest) violated(fmt::format("it turns by {:.3g} at point {}: it may have jumped to another branch", angle, k));
  }
}

/// Detects a branch that meets its own orbits again, shifted in time: it runs back along itself (a doubled branch that missed
/// its parent).
void find_retraces(const HybridSystem& system, const Branch& branch, const auto& violated) {
  constexpr std::size_t samples = 4, apart = 3;
  const std::size_t size = branch.points.size();
  for (std::size_t sample = 1; sample < samples; ++sample) {
    const std::size_t k = size * sample / samples;
    if (k < apart + 2) continue;
    // Next to a fold its two sides cannot be distinguished.
    const double value = branch.points[k].value, unit = parameter_unit(branch.points.front().value, branch.points.back().value);
    const auto turns = [&](const SpecialPoint& special) {
      return special.type == PointType::LP && std::abs(special.value - value) < 1e-6 * (unit + std::abs(value));
    };
    if (std::any_of(branch.special_points.begin(), branch.special_points.end(), turns)) continue;
    Branch earlier;
    earlier.period = branch.period;
    earlier.parameter = branch.parameter;
    earlier.parameters = branch.parameters;
    earlier.points.assign(branch.points.begin(), branch.points.begin() + static_cast<std::ptrdiff_t>(k - apart));
    if (branch_contains(system, earlier, branch.points[k].states, branch.points[k].value))
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
    if (k > 0 && !(point.arclength > branch.points[k - 1].arclength))
      violated(fmt::format("arclength does not grow at point {}", k));
    if (point.weakest_speed < least_kept_speed) {  // a free run does not reproduce it; its residual comes from its own equations
      if (!(point.checks.residual >= 0.0 && point.checks.residual < 1e-11))
        violated(fmt::format("point {} leaves a residual of {:.3g}", k, point.checks.residual));
      continue;
    }
    if (point.section_phase != problem.equations().section_phase()) problem = problem_of(point);
    const PeriodicOrbit again = problem.orbit(problem.pack(point.nodes, point.duration, point.value));
    if (!again.converged()) violated(fmt::format("point {} leaves a residual of {:.3g}", k, again.checks.residual));
    if (again.stable() != point.stable)
      violated(fmt::format("point {} is stored as {}stable and is not", k, point.stable ? "" : "un"));
    if (again.signature != point.signature) violated(fmt::format("point {} has another signature than stored", k));
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
    // Several special points within one step may cancel in the count: then it is no evidence.
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
