// SPDX-License-Identifier: GPL-3.0-or-later
// MapWork: computes rows of a map on several threads. The threads draw single points, of followed rows as soon as the next
// point can start (MapRow), each thread enough to fill its lanes. Rows are given in pieces; the last points of a piece may take
// long and share the lanes with those of the next piece.
#pragma once

#include <graze/floquet/follow/map_row.hpp>
#include <graze/lib/tasks/work_sharing.hpp>

#include <oneapi/tbb/mutex.h>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace graze {

class MapWork {
 public:
  /// Receives a piece and its points, ordered by row, layer, column; called by any thread. Points not reached because of
  /// MapOptions::cancelled are not_run.
  using Done = std::function<void(int first, std::vector<MapPoint> points)>;

  /// `threads`: number of threads that will call work(). @throws as check_map.
  MapWork(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
          const MapOptions& options, int threads, Done done);
  MapWork(const MapWork&) = delete;
  MapWork& operator=(const MapWork&) = delete;

  /// Adds `count` rows from row `first` on. @throws std::invalid_argument if the map does not have them.
  void give(int first, int count);
  /// Whether more rows would give a thread something to do. It limits the open work to one piece more than there are threads,
  /// or to followed rows that fill the lanes twice, because open work is lost if the program is killed.
  bool wants_more() const;
  /// No more rows will follow: idle threads stop waiting.
  void close();
  /// Run by each thread: works until it is closed and nothing is left to start. @throws the exception of a computation, and
  /// ends the other threads.
  void work();

 private:
  using Mutex = oneapi::tbb::mutex;  // held for a few us at a time: spin before sleeping

  /// Rows given in one call.
  struct Piece {
    int first;
    std::vector<MapPoint> points;
    std::size_t left;  ///< row tasks that are not finished
  };
  /// A followed row, or one independent point.
  struct RowTask {
    const MapLayer* layer;
    int row, column;  ///< of its first point
    MapRow points;
    std::shared_ptr<Piece> piece;
    MapRow::Next queued = MapRow::Next::likely;  ///< its queue: row_tasks_, unlikely_, or neither
  };
  /// A started point.
  struct Begun {
    std::shared_ptr<RowTask> row_task;
    std::shared_ptr<MapRow::Point> point;
  };

  std::optional<Begun> draw(std::size_t carried);
  bool has_some() const { return !row_tasks_.empty() || !unlikely_.empty(); }
  bool over() const { return failed_ || (closed_ && begun_ == 0 && !has_some()); }
  std::shared_ptr<RowTask> next(bool speculative);
  void queue(const std::shared_ptr<RowTask>& row_task);
  MotionTask<> find(TaskSlot& lane, Begun begun);
  MotionTask<> find_point(TaskSlot& lane, const Begun& begun, MapPoint& out);
  void publish(const Begun& begun, const Vector& state);
  std::optional<Begun> end(const Begun& begun, MapPoint found);
  const AttractorOptions* begin(const MapLayer& layer, const Vector& p, const std::optional<Vector>& from, Vector& start,
                                MapPoint& out) const;
  void take(const Vector& p, const Attractor& attractor, MapPoint& out) const;
  bool cancelled() const { return failed_ || (options_.cancelled && options_.cancelled()); }

  const HybridSystem system_;
  const Vector p_;
  const ParameterGrid grid_;
  const std::vector<MapLayer> layers_;
  const MapOptions options_;
  const std::size_t threads_;
  const Done done_;
  const bool followed_;  ///< some layers are followed
  AttractorOptions from_start_, from_neighbour_;
  Eigen::Index column_ = 0, row_ = 0;

  mutable Mutex mutex_;  ///< guards all members below
  std::condition_variable_any given_;
  WorkSharing exchange_{[this] {
    const std::lock_guard lock(mutex_);
    given_.notify_all();
  }};
  std::deque<std::shared_ptr<RowTask>> row_tasks_;  ///< ready to run
  std::deque<std::shared_ptr<RowTask>> unlikely_;   ///< ready, but their results will probably be rolled back
  std::size_t begun_ = 0;                           ///< points in progress
  std::size_t open_ = 0;                            ///< row tasks that are not finished
  std::size_t pieces_ = 0;                          ///< pieces that are not finished
  bool closed_ = false;
  std::atomic<bool> failed_ = false;
};

}  // namespace graze
