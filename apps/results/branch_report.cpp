// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/head.hpp>
#include <graze/apps/results/branch_report.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

namespace {

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
  const std::size_t count = branch.points.empty() ? 0 : branch.points.front().multipliers.values.size();
  const std::vector<Shown> first = {{"value", {branch.parameter}, 10}, {"state", state_headings(problem), 10}};
  const std::vector<Shown> second = {{"multipliers", multiplier_heads(count, true), 7}, {"stable"}};
  Table table{{"point"}, {}};
  add_columns(table, first);
  table.columns.emplace_back("z");
  add_columns(table, second);
  table.columns.emplace_back("admissible");
  if (!measured.points.empty()) add_columns(table, measured.points.front());
  // Thinned evenly; the first and the last point are always kept.
  const std::size_t size = branch.points.size();
  const std::size_t rows = std::min(size, std::max<std::size_t>(most, 2));
  for (std::size_t row = 0; row < rows; ++row) {
    const std::size_t i = rows == size ? row : row * (size - 1) / (rows - 1);
    const BranchPoint& point = branch.points[i];
    std::vector<std::string>& cells = table.rows.emplace_back();
    cells.push_back(std::to_string(i + 1));
    add_cells(cells, point_columns(), first, point);
    cells.push_back(label(point.impacts, point.isolated_impacts, branch.period));
    add_cells(cells, point_columns(), second, point);
    cells.push_back(point.admissible == Admissibility::admissible ? "yes" : "NO");
    if (!measured.points.empty()) add_cells(cells, measured.points[i], true);
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
  in_parallel_on(threads, places.size(), [&](std::size_t k) {
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

const Columns<BranchPoint>& point_columns() {
  using P = BranchPoint;
  static const Columns<P> list = joined<P>({{{"value", "of the parameter", &P::value}},
                                            states_columns<P>(),
                                            {Column<P>("arclength", "along the branch", &P::arclength).not_needed(),
                                             multipliers_column<P>(), duration_column<P>(), impacts_column<P>()},
                                            sticking_columns<P>(),
                                            {{"stable", "no multiplier lies outside the unit circle", &P::stable},
                                             admissible_column<P>(),
                                             Column<P>("checks", "proofs that come with the orbit", &P::checks).not_needed()}});
  return list;
}

const Columns<SpecialPoint>& special_point_columns() {
  using P = SpecialPoint;
  using O = PeriodicOrbit;
  static const Columns<P> list =
      joined<P>({{{"label", "type and running number", &P::label},
                  {"type", "of the point", &P::type},
                  {"value", "of the parameter", &P::value}},
                 of_part(joined<O>({states_columns<O>(),
                                    {multipliers_column<O>(),
                                     {"period", "of the branch that it lies on", &O::period},
                                     duration_column<O>(),
                                     impacts_column<O>()},
                                    sticking_columns<O>()}),
                         &P::orbit),
                 {{"marginal", "a multiplier lies on the unit circle", [](const P& point) { return is_marginal(point.type); },
                   only([](const P& point) { return is_marginal(point.type); })}},
                 of_part<P, O>({admissible_column<O>()}, &P::orbit),
                 {{"status", "whether it is located, or only lies in the interval", &P::status},
                  {"interval", "values that enclose it",
                   [](const P& point) {
                     return std::array{point.interval[0], point.interval[1]};
                   },
                   [](P& point, const std::array<double, 2>& ends) { std::copy(ends.begin(), ends.end(), point.interval); }},
                  {"precision", "estimated error of the value", &P::precision},
                  {"after_point", "number of the branch's point behind which it lies, from 0", &P::after_point},
                  {"details", "data of this type of point", &P::details}},
                 of_part<P, O>({Column<O>("checks", "proofs that come with the orbit", &O::checks).not_needed()}, &P::orbit),
                 {Column<P>("newton", "course of Newton's method", &P::newton).not_needed()}});
  return list;
}

const char* point_status_name(PointStatus status) { return status == PointStatus::converged ? "converged" : "bracketed"; }

const Columns<BranchParent>& parent_columns() {
  static const Columns<BranchParent> list = {{"branch", "number of the branch", &BranchParent::branch},
                                             {"label", "of its special point", &BranchParent::label}};
  return list;
}

const Columns<Symmetry>& symmetry_columns() {
  using S = Symmetry;
  static const Columns<S> list = {{"matrix", "S of x(t) -> S x(t + shift T), by rows",
                                   [](const S& symmetry) {
                                     std::vector<Vector> rows;
                                     for (const auto& row : symmetry.matrix.rowwise()) rows.emplace_back(row.transpose());
                                     return rows;
                                   },
                                   [](S& symmetry, const std::vector<Vector>& rows) {
                                     const auto n = static_cast<Eigen::Index>(rows.size());
                                     symmetry.matrix.resize(n, n);
                                     for (Eigen::Index i = 0; i < n; ++i)
                                       symmetry.matrix.row(i) = rows[static_cast<std::size_t>(i)].transpose();
                                   }},
                                  {"shift [forcing periods]", "lead of the mirror image", &S::shift}};
  return list;
}

const Columns<Branch>& branch_columns() {
  using B = Branch;
  const auto is_mirrored = [](const B& branch) { return branch.mirrored.has_value(); };
  static const Columns<B> list = {
      {"id", "number of the branch, from 1", &B::id},
      {"parent", "where it is born: a special point of another branch", &B::parent},
      {"period", "of its orbits", &B::period},
      {"mirrored", "a mirror image of it is a branch, too", is_mirrored, only(is_mirrored)},
      {"mirror", "the symmetry of that image", &B::mirrored, only(is_mirrored)},
      object<B>("stop", "why it ends",
                {{"reason", "in a word", &B::stop},
                 {"at", "value of the parameter", &B::stop_value},
                 {"message", "in a sentence", &B::message}}),
      {"points", "of the branch, in order", &B::points},
      {"special_points", "in the order in which they were met", &B::special_points},
      Column<B>("time_carried [time]", "time through which motion was computed for it", &B::time_carried).not_needed(),
      object<B>("first_failed", "last trial point before the branch broke off",
                {{"value", "of the parameter", [](const B& b) { return b.first_failed->value; }},
                 {"state", "at forcing phase 0", [](const B& b) { return b.first_failed->state(); },
                  only([](const B& b) { return !b.first_failed->states.empty(); })}})
          .where([](const B& b) { return b.first_failed.has_value(); })};
  return list;
}

Json special_point_schema() {
  const Json same = schema_of(parent_columns());
  return merged_schemas({with_quantities(schema_of(special_point_columns())),
                         object_schema({{"same_as", "a special point of an earlier branch that it is", same, false}})});
}

Json branches_schema() {
  const Member family = {"family", "id of the first branch of a curve that was followed both ways", JsonForm<int>::schema(),
                         false};
  Json branch = merged_schemas({schema_of(branch_columns()), object_schema({family})});
  branch["properties"]["points"]["items"] = with_quantities(schema_of(point_columns()));
  branch["properties"]["special_points"]["items"] = special_point_schema();
  return list_schema(branch);
}

std::string special_point_text(const SpecialPoint& point, const std::string& parameter) {
  std::string text = fmt::format("  {:<5} {} = {} +- {}  ({}, {}{})\n", point.label, parameter, rounded(point.value, 12),
                                 rounded(point.precision, 2), point_status_name(point.status), z_label(point.orbit),
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
  std::size_t count = 0;
  for (const Branch& branch : branches)
    for (const BranchPoint& point : branch.points) count = std::max(count, point.multipliers.values.size());
  const std::vector<Shown> shown = {{"impacts"},
                                    {"value", {branches.empty() ? "value" : branches.front().parameter}},
                                    {"state", state_columns(problem)},
                                    {"multipliers", multiplier_heads(count, false)}};
  Table table{{"branch", "parent", "label", "period"}, {}};
  add_columns(table, shown);
  table.columns.insert(table.columns.end(), {"stable", "admissible"});
  const auto first =
      std::find_if(measured.begin(), measured.end(), [](const BranchQuantities& one) { return !one.points.empty(); });
  if (first != measured.end()) add_columns(table, first->points.front());
  const auto add = [&](const Branch& branch, const std::string& name, const auto& columns, const auto& point,
                       std::optional<bool> stable, const QuantityValues& values) {
    std::vector<std::string> row = {std::to_string(branch.id), branch.parent ? branch.parent->label : "", name,
                                    std::to_string(branch.period)};
    add_cells(row, columns, shown, point);
    row.push_back(stable_cell(stable));
    add_cells(row, columns, {{"admissible"}}, point);
    add_cells(row, values, false);
    table.rows.push_back(std::move(row));
  };
  for (std::size_t b = 0; b < branches.size(); ++b) {
    const Branch& branch = branches[b];
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      add(branch, "", point_columns(), branch.points[i], branch.points[i].stable,
          measured.empty() ? QuantityValues{} : measured[b].points[i]);
      for (std::size_t s = 0; s < branch.special_points.size(); ++s)
        if (const SpecialPoint& special = branch.special_points[s]; special.after_point == i && special.type != PointType::EP)
          add(branch, special.label, special_point_columns(), special, stable_at(special),
              measured.empty() ? QuantityValues{} : measured[b].special_points[s]);
    }
  }
  return table;
}

namespace {

/// Completes a point with data of its problem. The duration is n forcing periods, or for an autonomous orbit the value in the
/// result. One multiplier of an autonomous orbit is trivial.
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
    if (!item.contains("arclength")) branch.points[i].arclength = static_cast<double>(i);  // older versions
  }
  for (std::size_t i = 0; i < branch.special_points.size(); ++i) {
    PeriodicOrbit& orbit = branch.special_points[i].orbit;
    p[index] = branch.special_points[i].value;
    orbit.parameters = p;
    orbit.state = orbit.states.front();
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
