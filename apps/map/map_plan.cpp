// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/map/map_plan.hpp>
#include <graze/apps/problem/flow_choice.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr double most_points = 1e9;  // of all layers: 40 GB of results

Json axis_json(const ParameterAxis& axis) {
  return {{"parameter", axis.parameter}, {"from", axis.from}, {"to", axis.to}, {"count", axis.count}};
}

ParameterAxis axis_of(const Json& json) { return {json.at("parameter"), json.at("from"), json.at("to"), json.at("count")}; }

/// The problem at a corner of the grid.
Problem corner(const MapPlan& plan, int column, int row) {
  Problem problem = plan.problem;
  set_parameter(problem, plan.grid.columns.parameter, plan.grid.columns.at(column), "--param");
  set_parameter(problem, plan.grid.rows.parameter, plan.grid.rows.at(row), "--param");
  return problem;
}

}  // namespace

std::vector<MapDirection> map_directions(const std::string& follow) {
  if (follow == "both") return {MapDirection::up, MapDirection::down};
  return {follow == "up" ? MapDirection::up : follow == "down" ? MapDirection::down : MapDirection::none};
}

LayerOrigin layer_origin(const MapPlan& plan, int layer) {
  const std::vector<MapDirection> directions = map_directions(plan.follow);
  const auto i = static_cast<std::size_t>(layer);
  return {plan.starts.at(i / directions.size()), directions[i % directions.size()]};
}

std::vector<MapLayer> layers_of(const MapPlan& plan) {
  std::vector<MapLayer> layers;
  for (int layer = 0; layer < plan.layers(); ++layer) {
    const LayerOrigin origin = layer_origin(plan, layer);
    const auto start = [given = origin.start, problem = plan.problem](const Vector& p) {
      return given ? *given : rest_state(problem, p);
    };
    layers.push_back({start, origin.follow});
  }
  return layers;
}

void set_quantities(MapPlan& plan, const std::vector<std::string>& texts) {
  plan.quantities = read_quantities(plan.problem, texts);
  plan.fields = map_fields(plan.quantities.list);
  if (texts.empty()) return;
  plan.options.measure = [quantities = plan.quantities, system = plan.problem.system](const Vector& p, const Attractor& found) {
    const std::vector<double> values = values_at(measure(quantities, system, p, found));
    return Vector(Eigen::Map<const Vector>(values.data(), static_cast<Eigen::Index>(values.size())));
  };
}

void check_plan(const MapPlan& plan) {
  const ParameterGrid& grid = plan.grid;
  if (plan.points() > most_points)
    throw std::invalid_argument(fmt::format("{} times {} points in {} are more than a thousand million; give fewer",
                                            grid.columns.count, grid.rows.count,
                                            counted(static_cast<std::size_t>(plan.layers()), "layer")));
  const std::vector<int> columns = {0, grid.columns.count - 1}, rows = {0, grid.rows.count - 1};
  std::vector<bool> admissible(plan.starts.size(), false);
  for (const int column : columns)
    for (const int row : rows) {
      const Problem problem = corner(plan, column, row);
      for (std::size_t i = 0; i < plan.starts.size(); ++i)
        if (!plan.starts[i] || mode_at(problem.system, 0.0, *plan.starts[i], problem.parameters)) admissible[i] = true;
    }
  for (std::size_t i = 0; i < plan.starts.size(); ++i)  // a start admissible at one corner is judged point by point
    if (!admissible[i] || (plan.starts[i] && !plan.starts[i]->allFinite()))
      start_state(corner(plan, columns[1], rows[1]), plan.starts[i]);
  check_map(plan.problem.system, plan.problem.parameters, grid, layers_of(plan), plan.options);
}

Json map_head(const MapPlan& plan, const std::vector<std::string>& settings) {
  Json starts = Json::array();
  for (const auto& start : plan.starts) starts.push_back(start ? to_json(*start) : Json(nullptr));
  const MapOptions& o = plan.options;
  Json options = {{"problem", plan.problem.file},
                  {"set", settings},
                  {"columns", axis_json(plan.grid.columns)},
                  {"rows", axis_json(plan.grid.rows)},
                  {"starts", starts},
                  {"follow", plan.follow},
                  {"settle", o.settle},
                  {"transient", o.transient},
                  {"max_period", o.max_period},
                  {"periods", o.periods},
                  {"standard_error", o.standard_error}};
  for (const Quantity& one : plan.quantities.list) options["y"].push_back(one.text);
  put_flow(options, o.flow.kind);
  return result_head("map/1", "map", plan.problem, options);
}

MapPlan plan_of(const Json& head) {
  try {
    if (const std::string schema = schema_of(head); schema != "graze.map/1")
      throw std::invalid_argument(fmt::format("this is {}; maps that can be read are of graze.map/1",
                                              schema.empty() ? "of no schema" : "of schema " + schema));
    MapPlan plan;
    plan.problem = problem_of(head);
    const Json& options = head.at("options");
    plan.problem.file = options.at("problem");
    plan.grid = {axis_of(options.at("columns")), axis_of(options.at("rows"))};
    plan.starts.clear();
    for (const Json& start : options.at("starts"))
      plan.starts.push_back(start.is_null() ? std::nullopt : std::optional(vector_from(start)));
    plan.follow = options.at("follow");
    plan.options.settle = options.at("settle");
    plan.options.transient = options.at("transient");
    plan.options.max_period = options.at("max_period");
    plan.options.periods = options.at("periods");
    plan.options.standard_error = options.at("standard_error");
    plan.options.flow.kind = flow_from(options);
    set_quantities(plan, options.value("y", std::vector<std::string>()));
    return plan;
  } catch (const Json::exception& error) {
    throw std::invalid_argument(std::string("this map does not say how it was computed: ") + plain(error));
  }
}

}  // namespace graze::apps
