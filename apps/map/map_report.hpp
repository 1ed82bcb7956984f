// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of a parameter map: how often each attractor occurs, all points as JSON or as a table, and the map as it is drawn.
#pragma once

#include <graze/apps/map/map_columns.hpp>
#include <graze/apps/map/map_file.hpp>
#include <graze/apps/text/long_text.hpp>

#include <cstddef>
#include <map>
#include <string>
#include <tuple>

namespace graze::apps {

/// A map as JSON, which is made in memory, has no more points than this.
inline constexpr double most_points_in_json = 1e6;

/// How many points of a layer are of a type, a period, a number of impacts, and stick.
using MapCounts = std::map<std::tuple<MapType, int, int, bool>, std::size_t>;

/// One for each layer; one pass over the rows.
std::vector<MapCounts> count_map(const MapPlan& plan, const MapRows& rows);
/// The same rows, counted while somebody else asks for each of them once. Both have to outlive them.
MapRows counting(const MapPlan& plan, const MapRows& rows, std::vector<MapCounts>& counts);

/// "z = 1/1", "z = ∞/1" where it sticks, "impactless", "chaotic", ...: for people.
std::string map_point_name(const MapCounts::key_type& kind);

/// "none: each point from rest", "up, from (0.5, 1)".
std::string layer_name(const MapPlan& plan, int layer);

/// The model with its parameters but the two of the grid.
std::string map_model(const MapPlan& plan);

std::string map_overview(const MapPlan& plan, const std::vector<MapCounts>& counts);

/// "layers": start, follow, counts, and all points, row by row. "sticking" tells where the null of "lambda_1" is -infinity.
Json map_json(const MapPlan& plan, const std::vector<MapCounts>& counts, const MapRows& rows);

/// The schema of "layers".
Json map_schema();

/// The rows of a result as map_json gives it. @throws std::invalid_argument if it does not fit the plan.
MapRows rows_from_json(const MapPlan& plan, const Json& result);

/// All points as a table, for --csv. Asks for the rows one by one, in order.
void map_csv(const MapPlan& plan, const MapRows& rows, int threads, const TextSink& sink);

}  // namespace graze::apps
