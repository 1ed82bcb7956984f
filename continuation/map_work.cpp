// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/map_work.hpp>
#include <graze/floquet/attractor_in_lanes.hpp>
#include <graze/lib/in_parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

/// So near a return, an orbit is looked for during the transient; Newton's method decides. In chaos a return so close is rare.
constexpr double recurrence = 1e-4;
constexpr int shortest_average = 200;
/// So many computations keep the lanes of a thread full. What it takes beyond them, others might have to wait for in the end.
constexpr std::size_t enough = 32;
/// Pieces in work beyond one for each thread.
constexpr std::size_t more_pieces = 1;

}  // namespace

MapWork::MapWork(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
                 const MapOptions& options, int threads, Done done)
    : system_(system), p_(p), grid_(grid), layers_(layers), options_(options),
      threads_(static_cast<std::size_t>(std::max(1, threads))), done_(std::move(done)) {
  check_map(system, p, grid, layers, options);
  column_ = static_cast<Eigen::Index>(parameter_index(system.parameters, grid.columns.parameter));
  row_ = static_cast<Eigen::Index>(parameter_index(system.parameters, grid.rows.parameter));
  from_start_.transient = options.settle;
  from_start_.max_period = options.max_period;
  from_start_.recurrence = recurrence;
  from_start_.periods_on_orbit = 0;  // the multipliers say it all
  from_start_.lyapunov.standard_error = options.standard_error;
  from_start_.lyapunov.max_periods = options.periods;
  from_start_.lyapunov.min_periods = std::min(options.periods, shortest_average);
  from_start_.lyapunov.aligning = shortest_average;
  from_start_.lyapunov.cancelled = [this] { return cancelled(); };
  from_neighbour_ = from_start_;
  from_neighbour_.transient = options.transient;
}

void MapWork::give(int first, int count) {
  if (first < 0 || count < 0 || first > grid_.rows.count - count)
    throw std::invalid_argument(
        fmt::format("rows {} to {} were asked for; the map has {}", first, first + count - 1, grid_.rows.count));
  const auto layers = static_cast<int>(layers_.size()), columns = grid_.columns.count;
  const auto size = static_cast<std::size_t>(count) * layers_.size() * static_cast<std::size_t>(columns);
  const auto piece = std::make_shared<Piece>(Piece{first, std::vector<MapPoint>(size), 0});
  const std::lock_guard lock(mutex_);
  for (int k = 0; k < count * layers; ++k) {
    const MapLayer& layer = layers_[static_cast<std::size_t>(k % layers)];
    MapPoint* const row = piece->points.data() + static_cast<std::ptrdiff_t>(k) * columns;
    const int together = layer.follow != MapDirection::none ? columns : 1;
    for (int column = 0; column < columns; column += together, ++piece->left)
      strands_.push_back({&layer, first + k / layers, column, together, row, piece});
  }
  if (piece->left > 0) ++pieces_;
  given_.notify_all();
}

bool MapWork::wants_more() const {
  const std::lock_guard lock(mutex_);
  return strands_.size() < enough * threads_ && pieces_ < threads_ + more_pieces;
}

void MapWork::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  given_.notify_all();
}

void MapWork::work() try {
  ManyMotions many(system_, from_start_.lyapunov.flow);
  LanePool(many, &exchange_).run([&](LanePlace& lane, std::size_t carried) -> std::optional<LaneTask<>> {
    auto strand = draw(carried);
    if (!strand) return std::nullopt;
    return follow(lane, std::move(*strand));
  });
} catch (...) {
  const std::lock_guard lock(mutex_);
  failed_ = true;
  given_.notify_all();
  throw;
}

/// What is begun next by a thread that carries so many; it waits for something to do if it has nothing.
std::optional<MapWork::Strand> MapWork::draw(std::size_t carried) {
  std::unique_lock lock(mutex_);
  if (carried == 0 && strands_.empty() && !exchange_.has_some()) {
    exchange_.begin_waiting();
    given_.wait(lock, [this] { return failed_ || !strands_.empty() || exchange_.has_some() || (closed_ && begun_ == 0); });
    exchange_.end_waiting();
  }
  if (carried == 0 && exchange_.has_some()) return std::nullopt;
  std::size_t most = divided_up(strands_.size() + begun_, threads_);
  if (threads_ > 1) most = std::min(most, std::max(enough, divided_up(strands_.size(), threads_)));
  if (failed_ || strands_.empty() || carried >= most) return std::nullopt;
  Strand strand = std::move(strands_.front());
  strands_.pop_front();
  ++begun_;
  return strand;
}

void MapWork::end(const Strand& strand) {
  {
    const std::lock_guard lock(mutex_);
    if (--begun_ == 0) given_.notify_all();
    if (--strand.piece->left > 0) return;
    --pieces_;
  }
  done_(strand.piece->first, std::move(strand.piece->points));
}

LaneTask<> MapWork::follow(LanePlace& lane, Strand strand) {
  Vector p = p_, start;
  p[row_] = grid_.rows.at(strand.row);
  std::optional<Vector> neighbour;
  for (int k = 0; k < strand.count; ++k) {
    const int column = strand.layer->follow == MapDirection::down ? strand.count - 1 - k : strand.column + k;
    p[column_] = grid_.columns.at(column);
    MapPoint& out = strand.out[column];
    if (const AttractorOptions* const finding = begin(*strand.layer, p, neighbour, start, out)) {
      if (cancelled()) break;
      const Attractor found = co_await find_attractor_in_lanes(lane, system_, p, start, *finding);
      take(found, out);
    }
    if (out.type == MapType::not_run) break;
    const bool arrived = out.type != MapType::inadmissible && out.type != MapType::lost;
    neighbour = arrived ? std::optional(out.state) : std::nullopt;
    if (options_.progress) options_.progress();
  }
  end(strand);
}

/// Where a point starts: without a neighbour's state, or where it lies inside the barrier by now, at the layer's start. Null:
/// it cannot.
const AttractorOptions* MapWork::begin(const MapLayer& layer, const Vector& p, const std::optional<Vector>& neighbour,
                                       Vector& start, MapPoint& out) const {
  out.state = Vector::Constant(static_cast<Eigen::Index>(system_.states), std::nan(""));
  const bool goes_on = neighbour && mode_at(system_, 0.0, *neighbour, p);
  start = goes_on ? *neighbour : layer.start(p);
  if (goes_on) return &from_neighbour_;
  if (mode_at(system_, 0.0, start, p)) return &from_start_;
  out.type = MapType::inadmissible;
  return nullptr;
}

void MapWork::take(const Attractor& attractor, MapPoint& out) const {
  const bool periodic = attractor.type == AttractorType::periodic;
  // A signal may have cut the average short without leaving a trace in an attractor that looks undecided.
  if (!periodic && cancelled()) return;
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

}  // namespace graze
