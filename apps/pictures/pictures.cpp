// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/pictures/seen.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze::apps {

const std::vector<PictureKind>& picture_kinds() {
  const std::string diagram_schema = "graze.diagram/1";
  static const std::vector<PictureKind> list = {
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
      diagram_picture(),
      of_schema(skeleton_picture(), diagram_schema),
      of_schema(sweep_picture(), diagram_schema),
      of_schema(exponents_picture(), diagram_schema),
  };
  return list;
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
    if (kind.schema == result.value("schema", "") && (kind.applies == nullptr || kind.applies(result)))
      names.push_back(kind.name);
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
    throw std::invalid_argument(fmt::format("there is no picture of \"{}\"; there is of {}", schema, fmt::join(known, ", ")));
  }
  std::string wanted = kind.empty() ? names.front() : kind;
  const std::string command = result.value("command", "");
  for (const PictureKind& candidate : picture_kinds())
    if (kind.empty() && candidate.schema == schema && !command.empty() && candidate.command == command) wanted = candidate.name;
  for (const PictureKind& candidate : picture_kinds()) {
    if (candidate.schema != schema || candidate.name != wanted) continue;
    try {
      return candidate.of_state ? draw_seen(candidate, result) : candidate.draw(result);
    } catch (const Json::exception& error) {
      throw std::invalid_argument(fmt::format("this result lacks what its picture needs: {}", plain(error)));
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

/// Whether a quantity stands in the place of the state.
bool is_seen(const Json& result, std::size_t state) {
  return result.contains(seen_quantity) && state == result.value(seen_place, std::size_t{0});
}

}  // namespace

std::vector<Barrier> barriers_of(const Json& result, bool vertical) {
  if (result.contains("states") || is_seen(result, 0)) return {};
  const double r = result.at("parameters").at("r").get<double>();
  return {{vertical, r, fmt::format("barrier x = r = {}", rounded(r, 6)), true}};
}

namespace {

/// What stands behind a name on an axis: " / mm", " (dimensionless)".
std::string unit_behind(const Json& result, const std::string& name) {
  if (!result.contains("states")) return " (dimensionless)";
  const Problem problem = problem_of(result);
  const auto unit = problem.written->units.find(name);
  return unit == problem.written->units.end() ? std::string() : " / " + unit->second;
}

}  // namespace

std::string parameter_label(const Json& result, const std::string& name) { return name + unit_behind(result, name); }

std::string time_label(const Json& result) {
  return result.contains("states") ? "t" + unit_behind(result, "t") : "tau (dimensionless time)";
}

std::string state_name(const Json& result, std::size_t state) {
  if (is_seen(result, state)) return result[seen_quantity];
  return result.contains("states") ? result["states"].at(state).get<std::string>() : state == 0 ? "x" : "x'";
}

std::string state_label(const Json& result, std::size_t state, bool at_phase_0) {
  const std::string name = state_name(result, state);
  if (is_seen(result, state)) return quantity_label(problem_of(result), name, at_phase_0);
  const bool forced = !result.contains("states") || is_forced(problem_of(result).system);
  return fmt::format("{}{}{}", name, at_phase_0 && forced ? " at forcing phase 0" : "", unit_behind(result, name));
}

}  // namespace graze::apps
