// SPDX-License-Identifier: GPL-3.0-or-later
// MapPlan: everything from which a parameter map is computed. It can be read from the head of the map's result, so that another
// process needs nothing else and a map can be resumed.
#pragma once

#include <graze/apps/map/map_columns.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/problem/problem.hpp>

#include <graze/floquet/follow/parameter_map.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

/// Directions of the layers of one start: each point from the start alone, or followed one way or both.
std::vector<MapDirection> map_directions(const std::string& follow);

struct MapPlan {
  Problem problem;
  ParameterGrid grid;
  std::vector<std::optional<Vector>> starts = {std::nullopt};  ///< nullopt: from rest, at the barrier if 0 lies beyond it
  std::string follow = "none";                                 ///< "none", "up", "down", "both"
  Quantities quantities;                                       ///< of --y
  std::vector<MapField> fields = map_fields();                 ///< of a point, quantities included
  MapOptions options;
  int chunk_rows = 1;  ///< rows per chunk

  int layers() const { return static_cast<int>(starts.size() * map_directions(follow).size()); }
  int chunks() const { return (grid.rows.count + chunk_rows - 1) / chunk_rows; }
  int first_row(int chunk) const { return chunk * chunk_rows; }
  int chunk_of(int row) const { return row / chunk_rows; }
  int rows_of(int chunk) const { return std::min(chunk_rows, grid.rows.count - first_row(chunk)); }
  /// Number of points of all layers together.
  double points() const { return static_cast<double>(layers()) * grid.columns.count * grid.rows.count; }
};

/// Start and direction of a layer: the directions of the first start come first.
struct LayerOrigin {
  std::optional<Vector> start;
  MapDirection follow = MapDirection::none;
};
LayerOrigin layer_origin(const MapPlan& plan, int layer);

/// The layers in the form that MapWork takes.
std::vector<MapLayer> layers_of(const MapPlan& plan);

/// Sets the quantities that are measured at each point.
void set_quantities(MapPlan& plan, const std::vector<std::string>& texts);

/// Checks the whole plan before anything is computed. @throws std::invalid_argument.
void check_plan(const MapPlan& plan);

/// The head of a map's result: "schema": "graze.map/1", model, parameters, options.
Json map_head(const MapPlan& plan, const std::vector<std::string>& settings);

/// The plan from a result's head. @throws std::invalid_argument if something is missing.
MapPlan plan_of(const Json& head);

}  // namespace graze::apps
