// SPDX-License-Identifier: GPL-3.0-or-later
// Report of a parameter map: how often each attractor occurs, and all points as JSON or as a table.
#pragma once

#include <graze/apps/map/map_columns.hpp>
#include <graze/apps/map/map_file.hpp>
#include <graze/apps/text/long_text.hpp>

#include <cstddef>
#include <map>
#include <string>
#include <tuple>

namespace graze::apps {

/// Largest number of points of a map in JSON, which is built in memory.
inline constexpr double most_points_in_json = 1e6;

/// Number of points of a layer with the same type, period, number of impacts and sticking.
using MapCounts = std::map<std::tuple<MapType, int, int, bool>, std::size_t>;

/// One for each layer, from one pass over the rows.
std::vector<MapCounts> count_map(const MapPlan& plan, const MapRows& rows);
/// The same rows, counted as the caller requests each of them once. `rows` and `counts` must outlive the result.
MapRows counting(const MapPlan& plan, const MapRows& rows, std::vector<MapCounts>& counts);

/// A name for people: "z = 1/1", "z = ∞/1" if it sticks, "impactless", "chaotic", ...
std::string map_point_name(const MapCounts::key_type& kind);

/// "none: each point from rest", "up, from (0.5, 1)".
std::string layer_name(const MapPlan& plan, int layer);

/// The model with its parameters, except the two of the grid.
std::string map_model(const MapPlan& plan);

std::string map_overview(const MapPlan& plan, const std::vector<MapCounts>& counts);

/// "layers": start, follow, counts, and all points, row by row. "sticking" marks the points whose "lambda_1", null in JSON, is
/// -infinity.
Json map_json(const MapPlan& plan, const std::vector<MapCounts>& counts, const MapRows& rows);

/// The schema of "layers".
Json map_schema();

/// The rows of a result written by map_json. @throws std::invalid_argument if it does not fit the plan.
MapRows rows_from_json(const MapPlan& plan, const Json& result);

/// All points as a table, for --csv. Requests the rows one by one, in order.
void map_csv(const MapPlan& plan, const MapRows& rows, int threads, const TextSink& sink);

}  // namespace graze::apps
