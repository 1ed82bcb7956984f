// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/follow/map_work.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

/// Returns this close trigger a search for an orbit during the transient; Newton's method decides. In chaos they are rare.
constexpr double recurrence = 1e-4;
constexpr int shortest_average = 200;
/// Number of computations that fills the lanes of a thread. Others might finally have to wait for any beyond it.
constexpr std::size_t enough = 32;

bool is_followed(const MapLayer& layer) { return layer.follow != MapDirection::none; }

}  // namespace

MapWork::MapWork(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
                 const MapOptions& options, int threads, Done done)
    : system_(system), p_(p), grid_(grid), layers_(layers), options_(options),
      threads_(static_cast<std::size_t>(std::max(1, threads))), done_(std::move(done)),
      followed_(std::any_of(layers.begin(), layers.end(), is_followed)) {
  check_map(system, p, grid, layers, options);
  column_ = static_cast<Eigen::Index>(parameter_index(system.parameters, grid.columns.parameter));
  row_ = static_cast<Eigen::Index>(parameter_index(system.parameters, grid.rows.parameter));
  from_start_.transient = options.settle;
  from_start_.max_period = options.max_period;
  from_start_.recurrence = recurrence;
  from_start_.periods_on_orbit = 0;  // the multipliers contain everything
  from_start_.lyapunov.standard_error = options.standard_error;
  from_start_.lyapunov.max_periods = options.periods;
  from_start_.lyapunov.min_periods = std::min(options.periods, shortest_average);
  from_start_.lyapunov.aligning = shortest_average;
  from_start_.lyapunov.flow = options.flow;
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
  std::vector<std::shared_ptr<RowTask>> row_tasks;
  for (int k = 0; k < count * layers; ++k) {
    const MapLayer& layer = layers_[static_cast<std::size_t>(k % layers)];
    MapPoint* const row = piece->points.data() + static_cast<std::ptrdiff_t>(k) * columns;
    const int together = is_followed(layer) ? columns : 1;
    for (int column = 0; column < columns; column += together, ++piece->left) {
      MapRow points({row + column, static_cast<std::size_t>(together)}, layer.follow == MapDirection::down);
      row_tasks.push_back(std::make_shared<RowTask>(&layer, first + k / layers, column, std::move(points), piece));
    }
  }
  const std::lock_guard lock(mutex_);
  open_ += row_tasks.size();
  row_tasks_.insert(row_tasks_.end(), std::make_move_iterator(row_tasks.begin()), std::make_move_iterator(row_tasks.end()));
  if (piece->left > 0) ++pieces_;
  given_.notify_all();
}

bool MapWork::wants_more() const {
  const std::lock_guard lock(mutex_);
  return row_tasks_.size() < enough * threads_ && (pieces_ <= threads_ || (followed_ && open_ < 2 * enough * threads_));
}

void MapWork::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  given_.notify_all();
}

void MapWork::work() try {
  LaneCarrier many(system_, from_start_.lyapunov.flow);
  TaskPool(many, &exchange_).run([&](TaskSlot& lane, std::size_t carried) -> std::optional<MotionTask<>> {
    auto begun = draw(carried);
    if (!begun) return std::nullopt;
    return find(lane, std::move(*begun));
  });
} catch (...) {
  const std::lock_guard lock(mutex_);
  failed_ = true;
  given_.notify_all();
  throw;
}

/// The next point for a thread with `carried` computations. Waits if the thread has nothing to do.
std::optional<MapWork::Begun> MapWork::draw(std::size_t carried) {
  std::unique_lock lock(mutex_);
  if (carried == 0 && !has_some() && !exchange_.has_some()) {
    exchange_.begin_waiting();
    given_.wait(lock, [this] { return over() || has_some() || exchange_.has_some(); });
    exchange_.end_waiting();
  }
  if (over()) exchange_.close();
  if (carried == 0 && exchange_.has_some()) return std::nullopt;
  std::size_t most = divide_rounding_up(row_tasks_.size() + unlikely_.size() + begun_, threads_);
  if (threads_ > 1) most = std::min(most, std::max(enough, divide_rounding_up(row_tasks_.size(), threads_)));
  if (failed_ || carried >= most) return std::nullopt;
  Begun begun{next(2 * carried < enough), {}};
  if (!begun.row_task) return std::nullopt;
  begun.point = begun.row_task->points.begin_next();
  ++begun_;
  return begun;
}

/// The next row task to continue; with `speculative`, also one that will probably be rolled back.
std::shared_ptr<MapWork::RowTask> MapWork::next(bool speculative) {
  if (row_tasks_.empty() && (!speculative || unlikely_.empty())) return nullptr;
  auto& from = row_tasks_.empty() ? unlikely_ : row_tasks_;
  std::shared_ptr<RowTask> first = std::move(from.front());
  from.pop_front();
  first->queued = MapRow::Next::none;
  return first;
}

/// Moves a row task to the queue that matches its present state.
void MapWork::queue(const std::shared_ptr<RowTask>& row_task) {
  const MapRow::Next next = row_task->points.next();
  if (next == row_task->queued) return;
  if (row_task->queued != MapRow::Next::none)
    std::erase(row_task->queued == MapRow::Next::likely ? row_tasks_ : unlikely_, row_task);
  row_task->queued = next;
  if (next == MapRow::Next::none) return;
  next == MapRow::Next::likely ? row_tasks_.push_front(row_task) : unlikely_.push_back(row_task);
  given_.notify_all();
}

void MapWork::publish(const Begun& begun, const Vector& state) {
  const std::lock_guard lock(mutex_);
  begun.row_task->points.publish(*begun.point, state);
  queue(begun.row_task);
}

/// Stores the result of a point. Returns the next point of its row, started, if no other thread is to start it.
std::optional<MapWork::Begun> MapWork::end(const Begun& begun, MapPoint found) {
  RowTask& row_task = *begun.row_task;
  std::size_t sure = 0;
  bool last = false;
  std::optional<Begun> next;
  {
    const std::lock_guard lock(mutex_);
    const bool finished = row_task.points.finished();
    sure = row_task.points.finish(*begun.point, std::move(found));
    if (!failed_ && row_task.queued == MapRow::Next::none && row_task.points.next() == MapRow::Next::likely) {
      next = Begun{begun.row_task, row_task.points.begin_next()};
    } else {
      if (--begun_ == 0) given_.notify_all();
      queue(begun.row_task);
    }
    if (!finished && row_task.points.finished()) {
      --open_;
      last = --row_task.piece->left == 0;
      if (last) --pieces_;
    }
  }
  for (; options_.progress && sure > 0; --sure) options_.progress();
  if (last) done_(row_task.piece->first, std::move(row_task.piece->points));
  return next;
}

MotionTask<> MapWork::find(TaskSlot& lane, Begun begun) {
  for (std::optional<Begun> next = std::move(begun); next;) {
    MapPoint out;
    co_await find_point(lane, *next, out);
    next = end(*next, std::move(out));
  }
}

MotionTask<> MapWork::find_point(TaskSlot& lane, const Begun& begun, MapPoint& out) {
  const MapRow::Point& point = *begun.point;
  const RowTask& row_task = *begun.row_task;
  const int column = row_task.column + static_cast<int>(row_task.points.place(point));
  Vector p = p_, start;
  p[row_] = grid_.rows.at(row_task.row);
  p[column_] = grid_.columns.at(column);
  const AttractorOptions* const begins = cancelled() ? nullptr : begin(*row_task.layer, p, point.from, start, out);
  if (!begins) co_return;
  AttractorOptions finding = *begins;
  finding.lyapunov.cancelled = [this, &point] { return point.dropped || cancelled(); };
  Attractor found = co_await approach_attractor(lane, system_, p, start, finding);
  if (found.termination == Termination::time && found.type != AttractorType::periodic) publish(begun, found.state);
  co_await average_on_attractor(lane, system_, p, found, finding);
  take(p, found, out);
}

/// Chooses the start of a point: the neighbour's state, or the layer's start if there is none or if it now lies inside the
/// barrier. Null: the start is inadmissible.
const AttractorOptions* MapWork::begin(const MapLayer& layer, const Vector& p, const std::optional<Vector>& from, Vector& start,
                                       MapPoint& out) const {
  out.state = Vector::Constant(static_cast<Eigen::Index>(system_.states), std::nan(""));
  const bool goes_on = from && mode_at(system_, 0.0, *from, p);
  start = goes_on ? *from : layer.start(p);
  if (goes_on) return &from_neighbour_;
  if (mode_at(system_, 0.0, start, p)) return &from_start_;
  out.type = MapType::inadmissible;
  return nullptr;
}

void MapWork::take(const Vector& p, const Attractor& attractor, MapPoint& out) const {
  const bool periodic = attractor.type == AttractorType::periodic;
  // A signal may have cut the average short, which an undecided attractor does not show.
  if (!periodic && cancelled()) return;
  if (attractor.termination != Termination::time || (!periodic && attractor.time_average.stop == LyapunovStop::failed)) {
    out.type = MapType::lost;
    return;
  }
  out.type = periodic ? MapType::periodic : attractor.type == AttractorType::chaotic ? MapType::chaotic : MapType::undecided;
  out.period = attractor.period;
  out.impacts = attractor.impacts;
  out.state = attractor.state;
  if (options_.measure) out.quantities = options_.measure(p, attractor);
  if (attractor.exponents.empty()) return;
  out.lambda_1 = attractor.exponents.front();
  out.standard_error = attractor.standard_errors.front();
}

}  // namespace graze
