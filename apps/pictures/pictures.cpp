// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/shown_quantity.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/text/json_member.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/equations/functions.hpp>
#include <graze/lib/equations/structure.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

namespace {

std::vector<PictureKind>& list() {
  const std::string diagram_schema = "graze.diagram/1";
  static std::vector<PictureKind> all = {
      branch_picture(),
      multipliers_picture(),
      skeleton_picture(),
      orbit_phase_picture(),
      orbit_time_picture(),
      point_phase_picture(),
      trajectory_time_picture(),
      trajectory_phase_picture(),
      section_picture(),
      verify_picture(),
      restitution_picture(),
      hard_limit_picture(),
      sweep_diagram_picture(),
      sweep_picture(),
      exponents_picture(),
      basins_picture(),
      map_picture(),
      map_exponent_picture(),
      map_quantity_picture(),
      diagram_picture(),
      of_schema(skeleton_picture(), diagram_schema),
      of_schema(sweep_picture(), diagram_schema),
      of_schema(exponents_picture(), diagram_schema),
  };
  return all;
}

}  // namespace

const std::vector<PictureKind>& picture_kinds() { return list(); }

void add_picture_kind(PictureKind kind) {
  const auto is_same = [&](const PictureKind& other) { return other.schema == kind.schema && other.name == kind.name; };
  if (std::any_of(list().begin(), list().end(), is_same))
    throw std::invalid_argument(fmt::format("{} has a picture {} already; give yours another name", kind.schema, kind.name));
  list().push_back(std::move(kind));
}

PictureKind of_schema(PictureKind kind, const std::string& schema) {
  kind.schema = schema;
  kind.command.clear();
  return kind;
}

std::vector<std::string> picture_names(const std::string& schema) {
  std::vector<std::string> names;
  for (const PictureKind& kind : picture_kinds())
    if (kind.schema == schema) names.push_back(kind.name);
  return names;
}

std::vector<std::string> pictures_for(const Json& result) {
  std::vector<std::string> names;
  for (const PictureKind& kind : picture_kinds())
    if (kind.schema == schema_of(result) && (kind.applies == nullptr || kind.applies(result))) names.push_back(kind.name);
  return names;
}

Picture picture_of(const Json& result, const std::string& kind) {
  const bool named = result.is_object() && result.contains("schema") && result["schema"].is_string();
  if (!named) throw std::invalid_argument("this is not a result of graze: it has no \"schema\"");
  const std::string schema = result["schema"];
  const std::vector<std::string> names = picture_names(schema);
  if (names.empty()) {
    std::vector<std::string> known;
    for (const PictureKind& candidate : picture_kinds())
      if (std::find(known.begin(), known.end(), candidate.schema) == known.end()) known.push_back(candidate.schema);
    throw std::invalid_argument(fmt::format(
        "unknown schema {}; known are {}; compute the result again with this graze, or plot it with the one that wrote it",
        schema, fmt::join(known, ", ")));
  }
  std::string wanted = kind.empty() ? names.front() : kind;
  const std::string command = text_of(result, "command");
  for (const PictureKind& candidate : picture_kinds())
    if (kind.empty() && candidate.schema == schema && !command.empty() && candidate.command == command) wanted = candidate.name;
  for (const PictureKind& candidate : picture_kinds()) {
    if (candidate.schema != schema || candidate.name != wanted) continue;
    try {
      return candidate.of_state ? draw_shown(candidate, result) : candidate.draw(result);
    } catch (const Json::exception& error) {
      throw std::invalid_argument(fmt::format("the picture cannot be drawn: {}", plain(error)));
    }
  }
  throw std::invalid_argument(fmt::format("of {} {}", schema, unknown_name("kind of picture", kind, names)));
}

std::string colour_of(std::size_t series) {
  static const std::vector<std::string> colours = {"#1f77b4", "#d95f02", "#2ca02c", "#9467bd", "#8c564b", "#17becf",
                                                   "#b22222", "#7f7f7f", "#bcbd22", "#e377c2", "#000080", "#006400"};
  return colours[series % colours.size()];
}

std::string model_title(const Json& result, const std::string& except) { return describe(problem_of(result), except); }

namespace {

/// Whether a quantity takes the place of the state.
bool is_shown(const Json& result, std::size_t state) {
  return result.contains(shown_quantity) && state == result.value(shown_place, std::size_t{0});
}

}  // namespace

std::vector<Barrier> barriers_of(const Json& result, std::size_t state, bool vertical) {
  if (is_shown(result, state)) return {};
  const Problem problem = problem_of(result);
  equations::Graph graph = *problem.written->graph;
  std::vector<Barrier> list;
  for (std::size_t i = 0; i < problem.system.events.size(); ++i) {
    if (!begins_contact(problem.system.events[i].kind)) continue;
    const equations::Expression guard = problem.written->events[i].guard;
    const auto level = equations::solve_guard(graph, guard, problem.system.states, [&](std::size_t one) { return one == state; });
    if (!level || equations::dependence(graph, level->value).moves()) continue;
    const equations::Expression both[] = {level->value, graph.derivative(guard, graph.state(state))};
    const Vector nowhere = Vector::Zero(static_cast<Eigen::Index>(problem.system.states));
    const std::vector<double> found = equations::values(graph, both, 0.0, nowhere, problem.parameters);
    const auto known = [&](const Barrier& other) { return other.position == found[0] && other.above == (found[1] > 0.0); };
    if (std::any_of(list.begin(), list.end(), known)) continue;  // the same barrier in another mode
    const std::string text = is_built_in(problem)
                                 ? fmt::format("barrier x = r = {}", rounded(found[0], 6))
                                 : fmt::format("stop at {} = {}", state_columns(problem)[state], rounded(found[0], 6));
    list.push_back({vertical, found[0], text, true, found[1] > 0.0});
  }
  return list;
}

StatePair portrait_plane(const Json& result) {
  if (result.contains(shown_plane)) return result[shown_plane].get<StatePair>();
  const Problem problem = problem_of(result);
  for (const equations::ModeExpressions& mode : problem.written->modes)
    for (std::size_t j = 1; j < problem.system.states; ++j)
      if (mode.field[0] == problem.written->graph->state(j)) return {0, j};
  return {0, 1};
}

namespace {

/// The unit after a name on an axis: " / mm", " (dimensionless)".
std::string unit_behind(const Json& result, const std::string& name) {
  if (!result.contains("states") && !result.contains("converted_from")) return " (dimensionless)";  // without making the system
  return unit_behind(problem_of(result), name);
}

}  // namespace

std::string unit_behind(const Problem& problem, const std::string& name) {
  const auto unit = problem.written->units.find(name);
  if (is_built_in(problem) && (unit == problem.written->units.end() || unit->second == "dimensionless"))
    return " (dimensionless)";
  return unit == problem.written->units.end() ? std::string() : " / " + unit->second;
}

bool has_forcing(const Json& result) { return !result.contains("states") || is_forced(problem_of(result).system); }

std::string parameter_label(const Json& result, const std::string& name) { return name + unit_behind(result, name); }

std::string time_label(const Json& result) {
  return result.contains("states") ? "t" + unit_behind(result, "t") : "tau (dimensionless time)";
}

std::string exponent_label(const Json& result) {
  if (!result.contains("states")) return "exponent (dimensionless)";
  const std::string unit = unit_behind(result, "t");  // " / s"
  return unit.empty() ? "exponent" : fmt::format("exponent / (1/{})", unit.substr(3));
}

std::string state_name(const Json& result, std::size_t state) {
  if (is_shown(result, state)) return result[shown_quantity];
  return result.contains("states") ? result["states"].at(state).get<std::string>() : state == 0 ? "x" : "x'";
}

std::string state_label(const Json& result, std::size_t state, bool at_phase_0) {
  const std::string name = state_name(result, state);
  if (is_shown(result, state)) return quantity_label(problem_of(result), name, at_phase_0);
  return fmt::format("{}{}{}", name, at_phase_0 && has_forcing(result) ? " at forcing phase 0" : "", unit_behind(result, name));
}

}  // namespace graze::apps
