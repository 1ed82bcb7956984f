// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/branch_report.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/long_text.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

/// Adds "states", those at forcing phase 0 after each period, where there is more than one.
void add_states(Json& out, const std::vector<Vector>& states) {
  if (states.size() < 2) return;
  out["states"] = to_json(states);
}

/// Adds "nodes" and their "section_phase" (over 2 pi), where they are not the states at forcing phase 0.
void add_nodes(Json& out, const std::vector<Vector>& nodes, double section_phase) {
  if (section_phase == 0.0) return;
  out["section_phase"] = section_phase;
  out["nodes"] = to_json(nodes);
}

Json point_json(const BranchPoint& point) {
  Json out = {{"value", point.value}, {"state", to_json(point.state())}};
  add_states(out, point.states);
  add_nodes(out, point.nodes, point.section_phase);
  out["arclength"] = point.arclength;
  out["multipliers"] = multipliers_json(point.multipliers);
  if (point.multipliers.section == Section::autonomous) out["duration"] = point.duration;
  out["impacts"] = point.impacts;
  add_sticking(out, point.impacts, point.isolated_impacts);
  out["stable"] = point.stable;
  out["admissible"] = point.admissible == Admissibility::admissible;
  out["checks"] = checks_json(point.checks);
  return out;
}

const char* status_name(PointStatus status) { return status == PointStatus::converged ? "converged" : "bracketed"; }

std::string detail_text(const Detail& detail) {
  if (const auto* text = std::get_if<std::string>(&detail)) return *text;
  if (const auto* number = std::get_if<double>(&detail)) return rounded(*number, 8);
  std::string out;
  for (const double number : std::get<std::vector<double>>(detail)) out += (out.empty() ? "" : ", ") + rounded(number, 8);
  return "[" + out + "]";
}

std::string multipliers_text(const FloquetMultipliers& multipliers, int digits) {
  std::string out;
  for (const std::complex<double>& mu : multipliers.values) out += (out.empty() ? "" : ", ") + rounded(mu, digits);
  return multipliers.valid ? out : "do not exist";
}

Table points_table(const Problem& problem, const Branch& branch, std::size_t most, const BranchQuantities& measured) {
  Table table{{"point", branch.parameter}, {}};
  for (const std::string& name : state_headings(problem)) table.columns.push_back(name);
  table.columns.emplace_back("z");
  const std::size_t count = branch.points.empty() ? 0 : branch.points.front().multipliers.values.size();
  for (std::size_t k = 1; k <= count; ++k) table.columns.push_back(fmt::format("multiplier {}", k));
  table.columns.insert(table.columns.end(), {"stable", "admissible"});
  if (!measured.points.empty()) add_columns(table, measured.points.front());
  // Evenly thinned out, the first and the last always among them.
  const std::size_t size = branch.points.size();
  const std::size_t rows = std::min(size, std::max<std::size_t>(most, 2));
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t i = rows == size ? row : row * (size - 1) / (rows - 1);
    const BranchPoint& point = branch.points[i];
    std::vector<std::string> cells = {std::to_string(i + 1), rounded(point.value, 10)};
    for (const double value : point.state()) cells.push_back(rounded(value, 10));
    cells.push_back(label(point.impacts, point.isolated_impacts, branch.period));
    for (std::size_t k = 0; k < count; ++k)
      cells.push_back(k < point.multipliers.values.size() ? rounded(point.multipliers.values[k], 7) : "-");
    cells.push_back(point.stable ? "yes" : "no");
    cells.push_back(point.admissible == Admissibility::admissible ? "yes" : "NO");
    if (!measured.points.empty()) add_cells(cells, measured.points[i], true);
    table.rows.push_back(std::move(cells));
  }
  return table;
}

}  // namespace

std::vector<BranchQuantities> measure(const Quantities& quantities, const HybridSystem& system,
                                      const std::vector<Branch>& branches, int threads) {
  std::vector<BranchQuantities> measured;
  if (quantities.empty()) return measured;
  struct Place {
    const Branch* branch;
    double value, duration;
    const std::vector<Vector>* states;
    QuantityValues* values;
  };
  std::vector<Place> places;
  measured.resize(branches.size());
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const Branch& branch = branches[b];
    measured[b].points.resize(branch.points.size());
    measured[b].special_points.resize(branch.special_points.size());
    for (std::size_t i = 0; i < branch.points.size(); ++i)
      places.push_back(
          {&branch, branch.points[i].value, branch.points[i].duration, &branch.points[i].states, &measured[b].points[i]});
    for (std::size_t i = 0; i < branch.special_points.size(); ++i) {
      const SpecialPoint& point = branch.special_points[i];
      places.push_back({&branch, point.value, point.orbit.duration, &point.orbit.states, &measured[b].special_points[i]});
    }
  }
  on_threads(threads, places.size(), [&](std::size_t k) {
    const Place& place = places[k];
    Vector p = place.branch->parameters;
    p[static_cast<Eigen::Index>(parameter_index(system.parameters, place.branch->parameter))] = place.value;
    *place.values = measure(quantities, system, p, {.states = *place.states, .duration = place.duration});
  });
  return measured;
}

void put_quantities(Json& list, const std::vector<BranchQuantities>& measured) {
  for (std::size_t b = 0; b < list.size(); ++b) {
    Json &points = list[b]["points"], &special = list[b]["special_points"];
    for (std::size_t i = 0; i < points.size(); ++i)
      put_quantities(points[i], measured.empty() ? QuantityValues{} : measured[b].points[i]);
    for (std::size_t i = 0; i < special.size(); ++i)
      put_quantities(special[i], measured.empty() ? QuantityValues{} : measured[b].special_points[i]);
  }
}

Json special_point_json(const SpecialPoint& point) {
  const PeriodicOrbit& orbit = point.orbit;
  Json out = {
      {"label", point.label}, {"type", point_type_name(point.type)}, {"value", point.value}, {"state", to_json(orbit.state)}};
  add_states(out, orbit.states);
  add_nodes(out, orbit.nodes, orbit.section_phase);
  out["multipliers"] = multipliers_json(orbit.multipliers);
  out["period"] = orbit.period;
  if (orbit.multipliers.section == Section::autonomous) out["duration"] = orbit.duration;
  out["impacts"] = orbit.impacts;
  add_sticking(out, orbit.impacts, orbit.isolated_impacts);
  if (is_marginal(point.type)) out["marginal"] = true;
  out["admissible"] = orbit.admissible == Admissibility::admissible;
  out["status"] = status_name(point.status);
  out["interval"] = {point.interval[0], point.interval[1]};
  out["precision"] = point.precision;
  out["after_point"] = point.after_point;
  out["details"] = Json::object();
  for (const auto& [name, detail] : point.details)
    std::visit([&, &key = name](const auto& value) { out["details"][key] = value; }, detail);
  out["checks"] = checks_json(orbit.checks);
  out["newton"] = {{"status", newton_status_text(point.newton.status)}, {"residuals", point.newton.residual_history}};
  return out;
}

Json branch_json(const Branch& branch) {
  Json out = {{"id", branch.id}, {"parent", nullptr}, {"period", branch.period}};
  reserve_members(out, 12);
  if (branch.parent) out["parent"] = {{"branch", branch.parent->branch}, {"label", branch.parent->label}};
  if (branch.mirrored) {
    out["mirrored"] = true;
    out["mirror"] = {{"matrix", Json::array()}, {"shift", branch.mirrored->shift}};
    for (const auto& row : branch.mirrored->matrix.rowwise()) out["mirror"]["matrix"].push_back(to_json(Vector(row.transpose())));
  }
  out["stop"] = {{"reason", branch_stop_name(branch.stop)}, {"at", branch.stop_value}, {"message", branch.message}};
  out["points"] = Json::array();
  for (const BranchPoint& point : branch.points) out["points"].push_back(point_json(point));
  out["special_points"] = Json::array();
  for (const SpecialPoint& point : branch.special_points) out["special_points"].push_back(special_point_json(point));
  out["time_carried"] = branch.time_carried;
  if (branch.first_failed) {
    out["first_failed"] = {{"value", branch.first_failed->value}};
    if (!branch.first_failed->states.empty()) out["first_failed"]["state"] = to_json(branch.first_failed->state());
  }
  return out;
}

std::string special_point_text(const SpecialPoint& point, const std::string& parameter) {
  std::string text = fmt::format("  {:<5} {} = {} +- {}  ({}, {}{})\n", point.label, parameter, rounded(point.value, 12),
                                 rounded(point.precision, 2), status_name(point.status), z_label(point.orbit),
                                 point.orbit.admissible == Admissibility::admissible ? "" : ", NOT ADMISSIBLE");
  if (point.status == PointStatus::bracketed)
    text += fmt::format("        between {} and {}\n", rounded(point.interval[0], 12), rounded(point.interval[1], 12));
  text += fmt::format("        state {}, multipliers {}\n", rounded_state(point.orbit.state, 12),
                      multipliers_text(point.orbit.multipliers, 11));
  std::string details;
  for (const auto& [name, detail] : point.details)
    details += fmt::format("{}{} {}", details.empty() ? "" : ", ", name, detail_text(detail));
  if (!details.empty()) text += "        " + details + "\n";
  return text;
}

std::string stability_text(const SpecialPoint& point) {
  if (const std::optional<bool> stable = stable_at(point)) return *stable ? "stable" : "unstable";
  return is_marginal(point.type) ? "marginal (a multiplier lies on the unit circle)"
                                 : "neither stable nor unstable to first order (the return map has no derivative there)";
}

std::string branch_text(const Problem& problem, const Branch& branch, std::size_t most, const SamePoints& same,
                        const BranchQuantities& measured) {
  std::string text = fmt::format("branch {}: period {}, {}", branch.id, branch.period, counted(branch.points.size(), "point"));
  if (branch.parent) text += fmt::format(", born at {} of branch {}", branch.parent->label, branch.parent->branch);
  if (branch.mirrored)
    text += fmt::format("; its mirror image, {}, is a branch too", symmetry_text(problem.system, *branch.mirrored));
  text += "\n";
  if (!branch.points.empty()) text += aligned(points_table(problem, branch, most, measured));
  if (branch.points.size() > most)
    text += fmt::format("  ({} of {} points shown; --all shows all)\n", std::max<std::size_t>(most, 2), branch.points.size());
  for (const SpecialPoint& point : branch.special_points) {
    if (point.type == PointType::EP) continue;
    const auto known = same.find(&point);
    text += known == same.end()
                ? special_point_text(point, branch.parameter)
                : fmt::format("  {:<5} is {} of branch {}\n", point.label, known->second.point->label, known->second.branch->id);
  }
  text += fmt::format("  stopped at {} = {}: {}\n", branch.parameter, rounded(branch.stop_value, 12), branch.message);
  return text;
}

std::string stable_cell(std::optional<bool> stable) { return !stable ? "" : *stable ? "yes" : "no"; }

Table branches_table(const Problem& problem, const std::vector<Branch>& branches, const std::vector<BranchQuantities>& measured) {
  Table table{{"branch", "parent", "label", "period", "impacts", branches.empty() ? "value" : branches.front().parameter}, {}};
  for (const std::string& name : state_columns(problem)) table.columns.push_back(name);
  std::size_t count = 0;
  for (const Branch& branch : branches)
    for (const BranchPoint& point : branch.points) count = std::max(count, point.multipliers.values.size());
  for (std::size_t k = 1; k <= count; ++k)
    table.columns.insert(table.columns.end(), {fmt::format("mu{}_re", k), fmt::format("mu{}_im", k)});
  table.columns.insert(table.columns.end(), {"stable", "admissible"});
  const auto first =
      std::find_if(measured.begin(), measured.end(), [](const BranchQuantities& one) { return !one.points.empty(); });
  if (first != measured.end()) add_columns(table, first->points.front());
  const auto add = [&](const Branch& branch, const std::string& name, int impacts, double value, const Vector& state,
                       const FloquetMultipliers& multipliers, std::optional<bool> stable, bool admissible,
                       const QuantityValues& values) {
    std::vector<std::string> row = {std::to_string(branch.id),
                                    branch.parent ? branch.parent->label : "",
                                    name,
                                    std::to_string(branch.period),
                                    std::to_string(impacts),
                                    exact(value)};
    for (const double component : state) row.push_back(exact(component));
    for (std::size_t k = 0; k < count; ++k) {
      const bool there = multipliers.valid && k < multipliers.values.size();
      row.push_back(there ? exact(multipliers.values[k].real()) : "");
      row.push_back(there ? exact(multipliers.values[k].imag()) : "");
    }
    row.push_back(stable_cell(stable));
    row.push_back(admissible ? "yes" : "no");
    add_cells(row, values, false);
    table.rows.push_back(std::move(row));
  };
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const Branch& branch = branches[b];
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      const BranchPoint& point = branch.points[i];
      add(branch, "", point.impacts, point.value, point.state(), point.multipliers, point.stable,
          point.admissible == Admissibility::admissible, measured.empty() ? QuantityValues{} : measured[b].points[i]);
      for (std::size_t s = 0; s < branch.special_points.size(); ++s)
        if (const SpecialPoint& special = branch.special_points[s]; special.after_point == i && special.type != PointType::EP)
          add(branch, special.label, special.orbit.impacts, special.value, special.orbit.state, special.orbit.multipliers,
              stable_at(special), special.orbit.admissible == Admissibility::admissible,
              measured.empty() ? QuantityValues{} : measured[b].special_points[s]);
    }
  }
  return table;
}

}  // namespace graze::apps
