// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/parameter_map.hpp>
#include <graze/floquet/attractor_in_lanes.hpp>
#include <graze/lib/in_parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <stdexcept>

namespace graze {

namespace {

/// So near a return, an orbit is looked for during the transient; Newton's method decides. In chaos a return so close is rare.
constexpr double recurrence = 1e-4;
constexpr int shortest_average = 200;
/// Points or rows that one thread takes at a time: many, so that the few that take long have company in the lanes, but so that
/// there is something for all threads.
constexpr std::size_t fewest_together = 32, most_together = 4096;

/// One grid of points on its way to being filled.
class Rows {
 public:
  Rows(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers, int first,
       const MapOptions& options)
      : system_(system), p_(p), grid_(grid), layers_(layers), options_(options), first_(first),
        column_(static_cast<Eigen::Index>(parameter_index(system.parameters, grid.columns.parameter))),
        row_(static_cast<Eigen::Index>(parameter_index(system.parameters, grid.rows.parameter))) {
    from_start_.transient = options.settle;
    from_start_.max_period = options.max_period;
    from_start_.recurrence = recurrence;
    from_start_.periods_on_orbit = 0;  // the multipliers say it all
    from_start_.lyapunov.standard_error = options.standard_error;
    from_start_.lyapunov.max_periods = options.periods;
    from_start_.lyapunov.min_periods = std::min(options.periods, shortest_average);
    from_start_.lyapunov.aligning = shortest_average;
    from_start_.lyapunov.cancelled = options.cancelled;
    from_neighbour_ = from_start_;
    from_neighbour_.transient = options.transient;
  }

  std::vector<MapPoint> compute(int count) const {
    const auto layers = static_cast<int>(layers_.size()), columns = grid_.columns.count;
    std::vector<MapPoint> points(static_cast<std::size_t>(count) * layers_.size() * static_cast<std::size_t>(columns));
    std::vector<Strand> strands;
    for (int k = 0; k < count * layers; ++k) {
      const MapLayer& layer = layers_[static_cast<std::size_t>(k % layers)];
      MapPoint* const row = points.data() + static_cast<std::ptrdiff_t>(k) * columns;
      if (layer.follow != MapDirection::none)
        strands.push_back({&layer, first_ + k / layers, 0, columns, row});
      else
        for (int column = 0; column < columns; ++column) strands.push_back({&layer, first_ + k / layers, column, 1, row});
    }
    const std::size_t together =
        std::clamp((strands.size() + threads_here() - 1) / threads_here(), fewest_together, most_together);
    in_parallel((strands.size() + together - 1) / together, [&](std::size_t k) {
      const std::span some = std::span(strands).subspan(k * together).first(std::min(together, strands.size() - k * together));
      ManyMotions many(system_, from_start_.lyapunov.flow);
      LanePool pool(many);
      pool.run(some.size(), [&](std::size_t i, LanePlace& lane) { return follow(lane, some[i]); });
    });
    return points;
  }

 private:
  /// Points of which each waits for the one before: a row that is followed, or one point.
  struct Strand {
    const MapLayer* layer;
    int row, column, count;  ///< columns from `column` on
    MapPoint* out;           ///< of the row
  };

  LaneTask<> follow(LanePlace& lane, const Strand& strand) const {
    Vector p = p_, start;
    p[row_] = grid_.rows.at(strand.row);
    std::optional<Vector> neighbour;
    for (int k = 0; k < strand.count; ++k) {
      const int column = strand.layer->follow == MapDirection::down ? strand.count - 1 - k : strand.column + k;
      p[column_] = grid_.columns.at(column);
      MapPoint& out = strand.out[column];
      if (const AttractorOptions* const finding = begin(*strand.layer, p, neighbour, start, out)) {
        if (options_.cancelled && options_.cancelled()) break;
        const Attractor found = co_await find_attractor_in_lanes(lane, system_, p, start, *finding);
        take(found, out);
      }
      if (out.type == MapType::not_run) break;
      const bool arrived = out.type != MapType::inadmissible && out.type != MapType::lost;
      neighbour = arrived ? std::optional(out.state) : std::nullopt;
      if (options_.progress) options_.progress();
    }
  }

  /// Where a point starts: without a neighbour's state, or where it lies inside the barrier by now, at the layer's start. Null:
  /// it cannot.
  const AttractorOptions* begin(const MapLayer& layer, const Vector& p, const std::optional<Vector>& neighbour, Vector& start,
                                MapPoint& out) const {
    out.state = Vector::Constant(static_cast<Eigen::Index>(system_.states), std::nan(""));
    const bool goes_on = neighbour && mode_at(system_, 0.0, *neighbour, p);
    start = goes_on ? *neighbour : layer.start(p);
    if (goes_on) return &from_neighbour_;
    if (mode_at(system_, 0.0, start, p)) return &from_start_;
    out.type = MapType::inadmissible;
    return nullptr;
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
  AttractorOptions from_start_, from_neighbour_;
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
