// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/parameter_map.hpp>
#include <graze/lib/in_parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace graze {

namespace {

/// So near a return, an orbit is looked for during the transient; Newton's method decides. In chaos a return so close is rare.
constexpr double recurrence = 1e-4;
constexpr int shortest_average = 200;
/// Points that one thread takes at a time: many, so that the few that take long have company in the lanes, but so that there is
/// something for all threads.
constexpr std::size_t fewest_together = 32, most_together = 4096;

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
    finding_.lyapunov.aligning = shortest_average;
    finding_.lyapunov.cancelled = options.cancelled;
  }

  std::vector<MapPoint> compute(int count) const {
    const auto layers = static_cast<int>(layers_.size()), columns = grid_.columns.count;
    std::vector<MapPoint> points(static_cast<std::size_t>(count) * layers_.size() * static_cast<std::size_t>(columns));
    // A strand is one row of one layer. Points that do not wait for each other are computed some at a time, side by side.
    std::vector<Task> free, heads;
    for (int strand = 0; strand < count * layers; ++strand) {
      const MapLayer& layer = layers_[static_cast<std::size_t>(strand % layers)];
      MapPoint* out = points.data() + static_cast<std::ptrdiff_t>(strand) * columns;
      const Task head{&layer, first_ + strand / layers, 0, std::nullopt, out};
      if (layer.follow != MapDirection::none) {
        heads.push_back(head);
        continue;
      }
      for (int column = 0; column < columns; ++column) free.push_back({&layer, head.row, column, std::nullopt, out + column});
    }
    const auto together = [threads = threads_here()](std::size_t size) {
      return std::clamp((size + threads - 1) / threads, fewest_together, most_together);
    };
    const auto groups = [&](std::size_t size) { return (size + together(size) - 1) / together(size); };
    const auto group = [&](const std::vector<Task>& tasks, std::size_t k) {
      const std::size_t begin = k * together(tasks.size()), end = std::min(tasks.size(), begin + together(tasks.size()));
      return std::vector<Task>(tasks.begin() + static_cast<std::ptrdiff_t>(begin),
                               tasks.begin() + static_cast<std::ptrdiff_t>(end));
    };
    in_parallel(groups(free.size()) + groups(heads.size()), [&](std::size_t k) {
      if (k < groups(heads.size())) return follow(group(heads, k));
      std::vector<Task> tasks = group(free, k - groups(heads.size()));
      run(tasks);
    });
    return points;
  }

 private:
  struct Task {
    const MapLayer* layer;
    int row, column;
    std::optional<Vector> state;  ///< that of the neighbour
    MapPoint* out;
  };

  /// Rows that are followed, column by column.
  void follow(std::vector<Task> heads) const {
    std::vector<MapPoint*> begin;
    for (const Task& head : heads) begin.push_back(head.out);
    for (int k = 0; k < grid_.columns.count; ++k) {
      for (std::size_t i = 0; i < heads.size(); ++i) {
        heads[i].column = heads[i].layer->follow == MapDirection::up ? k : grid_.columns.count - 1 - k;
        heads[i].out = begin[i] + heads[i].column;
      }
      run(heads);
      for (Task& head : heads) {
        if (head.out->type == MapType::not_run) return;
        const bool arrived = head.out->type != MapType::inadmissible && head.out->type != MapType::lost;
        head.state = arrived ? std::optional(head.out->state) : std::nullopt;
      }
    }
  }

  /// Without a neighbour's state, or where it lies inside the barrier by now, the layer's start is taken.
  void run(std::vector<Task>& tasks) const {
    std::vector<AverageStart> going_on, starting;
    std::vector<MapPoint*> of_going_on, of_starting;
    for (Task& task : tasks) {
      task.out->state = Vector::Constant(static_cast<Eigen::Index>(system_.states), std::nan(""));
      Vector p = p_;
      p[column_] = grid_.columns.at(task.column);
      p[row_] = grid_.rows.at(task.row);
      if (task.state && mode_at(system_, 0.0, *task.state, p)) {
        going_on.push_back({p, *task.state});
        of_going_on.push_back(task.out);
        continue;
      }
      const Vector start = task.layer->start(p);
      if (!mode_at(system_, 0.0, start, p)) {
        task.out->type = MapType::inadmissible;
        if (options_.progress) options_.progress();
        continue;
      }
      starting.push_back({p, start});
      of_starting.push_back(task.out);
    }
    find(starting, options_.settle, of_starting);
    find(going_on, options_.transient, of_going_on);
  }

  void find(const std::vector<AverageStart>& starts, int transient, const std::vector<MapPoint*>& out) const {
    if (starts.empty() || (options_.cancelled && options_.cancelled())) return;
    AttractorOptions finding = finding_;
    finding.transient = transient;
    const std::vector<Attractor> found = find_each_attractor(system_, starts, finding);
    for (std::size_t i = 0; i < found.size(); ++i) {
      take(found[i], *out[i]);
      if (options_.progress && out[i]->type != MapType::not_run) options_.progress();
    }
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
