// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/follow/map_work.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

void check_axis(const ParameterAxis& axis) {
  if (axis.count < 1 || !std::isfinite(axis.from) || !std::isfinite(axis.to) || axis.from > axis.to ||
      (axis.from == axis.to && axis.count > 1))
    throw std::invalid_argument(
        fmt::format("{} has {} values from {} to {}; a map needs at least one value, and the first below the last",
                    axis.parameter, axis.count, axis.from, axis.to));
}

}  // namespace

double ParameterAxis::at(int i) const { return i == 0 ? from : i == count - 1 ? to : from + i * ((to - from) / (count - 1)); }

std::string_view map_direction_name(MapDirection direction) {
  return direction == MapDirection::up ? "up" : direction == MapDirection::down ? "down" : "none";
}

std::string_view map_type_name(MapType type) {
  switch (type) {
  case MapType::undecided:
    return "undecided";
  case MapType::periodic:
    return "periodic";
  case MapType::chaotic:
    return "chaotic";
  case MapType::inadmissible:
    return "inadmissible";
  case MapType::lost:
    return "lost";
  case MapType::not_run:
    break;
  }
  return "not_run";
}

void check_map(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
               const MapOptions& options) {
  check_axis(grid.columns);
  check_axis(grid.rows);
  const std::size_t column = parameter_index(system.parameters, grid.columns.parameter);
  const std::size_t row = parameter_index(system.parameters, grid.rows.parameter);
  if (column == row)
    throw std::invalid_argument(fmt::format("both parameters of the map are {}; it needs two", grid.columns.parameter));
  for (const double x : {grid.columns.from, grid.columns.to})  // ranges are intervals: checking the corners suffices
    for (const double y : {grid.rows.from, grid.rows.to}) {
      Vector corner = p;
      corner[static_cast<Eigen::Index>(column)] = x;
      corner[static_cast<Eigen::Index>(row)] = y;
      check_parameters(system.parameters, corner);
    }
  if (layers.empty()) throw std::invalid_argument("the map has no start; at least one is needed");
  for (const auto& [name, value, least] : {std::tuple{"settle", options.settle, 0},
                                           {"transient", options.transient, 0},
                                           {"max_period", options.max_period, 1},
                                           {"periods", options.periods, 1}})
    if (value < least) throw std::invalid_argument(fmt::format("{} is {}; allowed is a whole number >= {}", name, value, least));
  if (!(options.standard_error > 0.0))
    throw std::invalid_argument(fmt::format("standard_error is {}; allowed is > 0", options.standard_error));
}

std::vector<MapPoint> map_rows(const HybridSystem& system, const Vector& p, const ParameterGrid& grid,
                               const std::vector<MapLayer>& layers, int first, int count, const MapOptions& options) {
  std::vector<MapPoint> points;
  const std::size_t threads = available_threads();
  MapWork map(system, p, grid, layers, options, static_cast<int>(threads),
              [&points](int, std::vector<MapPoint> finished) { points = std::move(finished); });
  map.give(first, count);
  map.close();
  in_parallel(threads, [&map](std::size_t) { map.work(); });
  return points;
}

}  // namespace graze
