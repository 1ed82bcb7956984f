// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/head.hpp>
#include <graze/apps/results/branch_reading.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

namespace {

std::vector<Vector> vectors_from(const Json& json) {
  std::vector<Vector> list;
  for (const Json& item : json) list.push_back(vector_from(item));
  return list;
}

std::vector<Vector> states_from(const Json& point) {
  return point.contains("states") ? vectors_from(point["states"]) : std::vector<Vector>{vector_from(point.at("state"))};
}

/// Nodes of the shooting equations: the states at phase 0 unless the result has others.
void add_nodes(const Json& point, const std::vector<Vector>& states, std::vector<Vector>& nodes, double& section_phase) {
  section_phase = point.value("section_phase", 0.0);
  nodes = point.contains("nodes") ? vectors_from(point["nodes"]) : states;
}

/// Of n forcing periods, or what stands there of an autonomous orbit; one of its multipliers is trivial then.
double duration_from(const Json& point, const HybridSystem& system, const Vector& p, int period,
                     FloquetMultipliers& multipliers) {
  if (is_forced(system)) return period * forcing_period(system, p);
  multipliers.section = Section::autonomous;
  multipliers.trivial = 1;
  return point.at("duration");
}

Admissibility admissibility_from(const Json& point) {
  return point.at("admissible").get<bool>() ? Admissibility::admissible : Admissibility::inadmissible;
}

OrbitChecks checks_from(const Json& json) {
  const auto number = [](const Json& value) { return value.is_null() ? -1.0 : value.get<double>(); };
  OrbitChecks checks;
  checks.residual = number(json.at("residual"));
  checks.liouville = number(json.at("liouville"));
  if (json.contains("finite_difference_applicable")) {
    checks.finite_difference.emplace();
    checks.finite_difference->applicable = json["finite_difference_applicable"];
    checks.finite_difference->disagreement = number(json.at("finite_difference"));
    checks.finite_difference->error_estimate = json.value("finite_difference_error", 0.0);
  }
  return checks;
}

NewtonReport newton_from(const Json& json) {
  NewtonReport report;
  const std::string text = json.at("status");
  for (const NewtonStatus status : {NewtonStatus::converged, NewtonStatus::iteration_limit, NewtonStatus::stalled,
                                    NewtonStatus::evaluation_failed, NewtonStatus::singular})
    if (newton_status_text(status) == text) report.status = status;
  for (const Json& residual : json.at("residuals"))
    report.residual_history.push_back(residual.is_null() ? std::nan("") : residual.get<double>());
  return report;
}

SpecialPoint special_point_from(const Json& json, const HybridSystem& system, const Vector& p, std::size_t parameter) {
  SpecialPoint point;
  point.type = point_type(json.at("type").get<std::string>());
  point.label = json.at("label");
  point.value = json.at("value");
  point.status = json.at("status") == "converged" ? PointStatus::converged : PointStatus::bracketed;
  point.interval[0] = json.at("interval").at(0);
  point.interval[1] = json.at("interval").at(1);
  point.precision = json.at("precision");
  point.after_point = json.at("after_point");
  PeriodicOrbit& orbit = point.orbit;
  orbit.parameters = p;
  orbit.parameters[static_cast<Eigen::Index>(parameter)] = point.value;
  orbit.period = json.at("period");
  orbit.states = states_from(json);
  orbit.state = orbit.states.front();
  add_nodes(json, orbit.states, orbit.nodes, orbit.section_phase);
  orbit.impacts = json.at("impacts");
  orbit.isolated_impacts = json.value("isolated_impacts", orbit.impacts);
  orbit.multipliers = multipliers_from(json.at("multipliers"));
  orbit.duration = duration_from(json, system, orbit.parameters, orbit.period, orbit.multipliers);
  orbit.admissible = admissibility_from(json);
  orbit.newton.status = NewtonStatus::converged;
  if (json.contains("checks")) orbit.checks = checks_from(json["checks"]);
  if (json.contains("newton")) point.newton = newton_from(json["newton"]);
  for (const auto& [name, value] : json.at("details").items()) {
    if (value.is_string()) point.details.insert_or_assign(name, value.get<std::string>());
    if (value.is_number()) point.details.insert_or_assign(name, value.get<double>());
    if (value.is_array()) point.details.insert_or_assign(name, value.get<std::vector<double>>());
  }
  return point;
}

BranchStop stop_from(const std::string& name) {
  constexpr std::array all = {BranchStop::reached_bound, BranchStop::parameter_range, BranchStop::point_limit,
                              BranchStop::grazing,       BranchStop::step_too_small,  BranchStop::chatter,
                              BranchStop::returned,      BranchStop::start_failed,    BranchStop::interrupted};
  for (const BranchStop stop : all)
    if (branch_stop_name(stop) == name) return stop;
  throw std::invalid_argument(fmt::format("a branch stopped for the reason \"{}\", which is not known", name));
}

namespace {

Symmetry symmetry_from(const Json& json) {
  const Json& rows = json.at("matrix");
  const auto n = static_cast<Eigen::Index>(rows.size());
  Symmetry out{Matrix(n, n), json.at("shift")};
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      out.matrix(i, j) = rows.at(static_cast<std::size_t>(i)).at(static_cast<std::size_t>(j)).get<double>();
  return out;
}

}  // namespace

Branch branch_from(const Json& json, const Problem& problem, const std::string& parameter) {
  const std::size_t index = parameter_index(problem.system.parameters, parameter);
  Branch branch;
  branch.id = json.at("id");
  if (json.value("mirrored", false)) branch.mirrored = symmetry_from(json.at("mirror"));
  if (!json.at("parent").is_null())
    branch.parent = BranchParent{json["parent"].at("branch").get<int>(), json["parent"].at("label").get<std::string>()};
  branch.period = json.at("period");
  branch.parameter = parameter;
  branch.parameters = problem.parameters;
  branch.stop = stop_from(json.at("stop").at("reason"));
  branch.stop_value = json["stop"].at("at");
  branch.message = json["stop"].at("message");
  branch.time_carried = json.value("time_carried", 0.0);
  for (const Json& item : json.at("points")) {
    BranchPoint point;
    point.value = item.at("value");
    Vector p = problem.parameters;
    p[static_cast<Eigen::Index>(index)] = point.value;
    point.states = states_from(item);
    add_nodes(item, point.states, point.nodes, point.section_phase);
    point.arclength = item.value("arclength", static_cast<double>(branch.points.size()));
    point.multipliers = multipliers_from(item.at("multipliers"));
    point.duration = duration_from(item, problem.system, p, branch.period, point.multipliers);
    point.impacts = item.at("impacts");
    point.isolated_impacts = item.value("isolated_impacts", point.impacts);
    point.stable = item.at("stable");
    if (item.contains("checks")) point.checks = checks_from(item["checks"]);
    point.admissible = admissibility_from(item);
    branch.points.push_back(std::move(point));
  }
  if (!branch.points.empty()) branch.parameters[static_cast<Eigen::Index>(index)] = branch.points.front().value;
  for (const Json& item : json.at("special_points"))
    branch.special_points.push_back(special_point_from(item, problem.system, branch.parameters, index));
  return branch;
}

}  // namespace

FloquetMultipliers multipliers_from(const Json& json) {
  FloquetMultipliers out;
  for (const Json& mu : json) out.values.emplace_back(mu.at(0).get<double>(), mu.at(1).get<double>());
  out.valid = !out.values.empty();
  return out;
}

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
