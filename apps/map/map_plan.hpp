// SPDX-License-Identifier: GPL-3.0-or-later
// MapPlan: all that a parameter map is computed from. It can be read off the head of the map's result, so that another process
// needs nothing else, and a map can be gone on with.
#pragma once

#include <graze/apps/map/map_columns.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/problem/problem.hpp>

#include <graze/floquet/follow/parameter_map.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

/// Layers of one map: each start alone, or followed one way or both.
std::vector<MapDirection> map_directions(const std::string& follow);

struct MapPlan {
  Problem problem;
  ParameterGrid grid;
  std::vector<std::optional<Vector>> starts = {std::nullopt};  ///< without one: at rest, at the barrier where 0 lies beyond it
  std::string follow = "none";                                 ///< "none", "up", "down", "both"
  Quantities quantities;                                       ///< of --y
  std::vector<MapField> fields = map_fields();                 ///< of a point, with the quantities
  MapOptions options;
  int chunk_rows = 1;  ///< a chunk is so many rows

  int layers() const { return static_cast<int>(starts.size() * map_directions(follow).size()); }
  int chunks() const { return (grid.rows.count + chunk_rows - 1) / chunk_rows; }
  int first_row(int chunk) const { return chunk * chunk_rows; }
  int chunk_of(int row) const { return row / chunk_rows; }
  int rows_of(int chunk) const { return std::min(chunk_rows, grid.rows.count - first_row(chunk)); }
  /// Points of all layers together.
  double points() const { return static_cast<double>(layers()) * grid.columns.count * grid.rows.count; }
};

/// Start and direction of a layer: the directions of the first start come first.
struct LayerOrigin {
  std::optional<Vector> start;
  MapDirection follow = MapDirection::none;
};
LayerOrigin layer_origin(const MapPlan& plan, int layer);

/// What MapWork is given.
std::vector<MapLayer> layers_of(const MapPlan& plan);

/// Sets what the plan's problem is asked for at each point.
void set_quantities(MapPlan& plan, const std::vector<std::string>& texts);

/// Checks the whole plan before anything is computed. @throws std::invalid_argument.
void check_plan(const MapPlan& plan);

/// The head of its result: "schema": "graze.map/1", model, parameters, options.
Json map_head(const MapPlan& plan, const std::vector<std::string>& settings);

/// The plan of a result's head. @throws std::invalid_argument if something is missing.
MapPlan plan_of(const Json& head);

}  // namespace graze::apps
