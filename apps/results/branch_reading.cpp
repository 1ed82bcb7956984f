// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/head.hpp>
#include <graze/apps/results/branch_reading.hpp>
#include <graze/apps/results/branch_report.hpp>

#include <fmt/format.h>

#include <stdexcept>

namespace graze::apps {

namespace {

/// What a point has from its problem. The duration is of n forcing periods, or what the result has of an autonomous orbit; one of
/// its multipliers is trivial then.
void complete(auto& orbit, const Json& json, const HybridSystem& system, const Vector& p, int period) {
  orbit.duration = is_forced(system) ? period * forcing_period(system, p) : json.at("duration").get<double>();
  if (is_forced(system)) return;
  orbit.multipliers.section = Section::autonomous;
  orbit.multipliers.trivial = 1;
}

Branch branch_from(const Json& json, const Problem& problem, const std::string& parameter) {
  const auto index = static_cast<Eigen::Index>(parameter_index(problem.system.parameters, parameter));
  Branch branch = value_of<Branch>(json);
  branch.parameter = parameter;
  branch.parameters = problem.parameters;
  if (!branch.points.empty()) branch.parameters[index] = branch.points.front().value;
  Vector p = branch.parameters;
  for (std::size_t i = 0; i < branch.points.size(); ++i) {
    const Json& item = json.at("points").at(i);
    p[index] = branch.points[i].value;
    complete(branch.points[i], item, problem.system, p, branch.period);
    if (!item.contains("arclength")) branch.points[i].arclength = static_cast<double>(i);  // of older versions
  }
  for (std::size_t i = 0; i < branch.special_points.size(); ++i) {
    PeriodicOrbit& orbit = branch.special_points[i].orbit;
    p[index] = branch.special_points[i].value;
    orbit.parameters = p;
    orbit.state = orbit.states.front();
    orbit.newton.status = NewtonStatus::converged;
    complete(orbit, json.at("special_points").at(i), problem.system, p, orbit.period);
  }
  return branch;
}

}  // namespace

std::vector<Branch> branches_from_json(const Json& result) {
  const Problem problem = problem_of(result);
  std::vector<Branch> branches;
  try {
    const std::string parameter = result.at("parameter");
    for (const Json& json : result.at("branches")) branches.push_back(branch_from(json, problem, parameter));
  } catch (const nlohmann::json::exception&) {
    throw std::invalid_argument(
        fmt::format("branch {} of the result is damaged or lacks something; compute it anew", branches.size() + 1));
  }
  return branches;
}

}  // namespace graze::apps
