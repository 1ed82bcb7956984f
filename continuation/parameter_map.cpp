// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/parameter_map.hpp>

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace graze {

namespace {

/// So near a return, an orbit is looked for during the transient; Newton's method decides. In chaos a return so close is rare.
constexpr double recurrence = 1e-4;
constexpr int shortest_average = 200;

/// One grid of points on its way to being filled.
class Rows {
 public:
  Rows(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers, int first,
       const MapOptions& options)
      : system_(system), p_(p), grid_(grid), layers_(layers), options_(options), first_(first),
        column_(static_cast<Eigen::Index>(parameter_index(system.parameters, grid.columns.parameter))),
        row_(static_cast<Eigen::Index>(parameter_index(system.parameters, grid.rows.parameter))) {
    finding_.max_period = options.max_period;
    finding_.recurrence = recurrence;
    finding_.periods_on_orbit = 0;  // the multipliers say it all
    finding_.lyapunov.standard_error = options.standard_error;
    finding_.lyapunov.max_periods = options.periods;
    finding_.lyapunov.min_periods = std::min(options.periods, shortest_average);
    finding_.lyapunov.cancelled = options.cancelled;
  }

  std::vector<MapPoint> compute(int count) const {
    const auto layers = static_cast<int>(layers_.size()), columns = grid_.columns.count;
    std::vector<MapPoint> points(static_cast<std::size_t>(count) * layers_.size() * static_cast<std::size_t>(columns));
    // A strand is one row of one layer. Isolated: a thread that waits here must not begin with something else meanwhile.
    oneapi::tbb::this_task_arena::isolate([&] {
      oneapi::tbb::parallel_for(0, count * layers, [&](int strand) {
        const MapLayer& layer = layers_[static_cast<std::size_t>(strand % layers)];
        const int row = first_ + strand / layers;
        MapPoint* out = points.data() + static_cast<std::ptrdiff_t>(strand) * columns;
        if (layer.follow == MapDirection::none)
          oneapi::tbb::parallel_for(0, columns, [&](int column) { out[column] = point(layer, row, column, std::nullopt); });
        else
          follow(layer, row, out);
      });
    });
    return points;
  }

 private:
  void follow(const MapLayer& layer, int row, MapPoint* out) const {
    std::optional<Vector> state;
    for (int k = 0; k < grid_.columns.count; ++k) {
      const int column = layer.follow == MapDirection::up ? k : grid_.columns.count - 1 - k;
      out[column] = point(layer, row, column, state);
      if (out[column].type == MapType::not_run) return;
      const bool arrived = out[column].type != MapType::inadmissible && out[column].type != MapType::lost;
      state = arrived ? std::optional(out[column].state) : std::nullopt;
    }
  }

  /// `state`: that of the neighbour; without one, or where it lies inside the barrier by now, the layer's start is taken.
  MapPoint point(const MapLayer& layer, int row, int column, const std::optional<Vector>& state) const {
    MapPoint out;
    out.state = Vector::Constant(static_cast<Eigen::Index>(system_.states), std::nan(""));
    if (options_.cancelled && options_.cancelled()) return out;
    Vector p = p_;
    p[column_] = grid_.columns.at(column);
    p[row_] = grid_.rows.at(row);
    AttractorOptions finding = finding_;
    const bool goes_on = state && admissible(*state, p);
    finding.transient = goes_on ? options_.transient : options_.settle;
    const Vector start = goes_on ? *state : layer.start(p);
    if (!goes_on && !admissible(start, p))
      out.type = MapType::inadmissible;
    else
      take(find_attractor(system_, p, start, finding), out);
    if (options_.progress && out.type != MapType::not_run) options_.progress();
    return out;
  }

  bool admissible(const Vector& state, const Vector& p) const {
    return !system_.initial_mode || system_.initial_mode(0.0, state, p).has_value();
  }

  void take(const Attractor& attractor, MapPoint& out) const {
    const bool periodic = attractor.type == AttractorType::periodic;
    // A signal may have cut the average short without leaving a trace in an attractor that looks undecided.
    if (!periodic && options_.cancelled && options_.cancelled()) return;
    if (attractor.termination != Termination::time || (!periodic && attractor.time_average.stop == LyapunovStop::failed)) {
      out.type = MapType::lost;
      return;
    }
    out.type = periodic ? MapType::periodic : attractor.type == AttractorType::chaotic ? MapType::chaotic : MapType::undecided;
    out.period = attractor.period;
    out.impacts = attractor.impacts;
    out.state = attractor.state;
    if (attractor.exponents.empty()) return;
    out.lambda_1 = attractor.exponents.front();
    out.standard_error = attractor.standard_errors.front();
  }

  const HybridSystem& system_;
  const Vector& p_;
  const ParameterGrid& grid_;
  const std::vector<MapLayer>& layers_;
  const MapOptions& options_;
  AttractorOptions finding_;
  int first_;
  Eigen::Index column_, row_;
};

void check_axis(const ParameterAxis& axis) {
  if (axis.count < 1 || !std::isfinite(axis.from) || !std::isfinite(axis.to) || axis.from > axis.to ||
      (axis.from == axis.to && axis.count > 1))
    throw std::invalid_argument(fmt::format("{} has {} values from {} to {}; a map needs at least one, from less to more",
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
  for (const double x : {grid.columns.from, grid.columns.to})  // ranges are intervals: the corners speak for all
    for (const double y : {grid.rows.from, grid.rows.to}) {
      Vector corner = p;
      corner[static_cast<Eigen::Index>(column)] = x;
      corner[static_cast<Eigen::Index>(row)] = y;
      check_parameters(system.parameters, corner);
      forcing_period(system, corner);
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
  check_map(system, p, grid, layers, options);
  if (first < 0 || count < 0 || first > grid.rows.count - count)
    throw std::invalid_argument(
        fmt::format("rows {} to {} were asked for; the map has {}", first, first + count - 1, grid.rows.count));
  return Rows(system, p, grid, layers, first, options).compute(count);
}

}  // namespace graze
