// SPDX-License-Identifier: GPL-3.0-or-later
// MapWork: rows of a map on their way, on several threads. The threads take points one by one, of rows that are followed as soon
// as they can begin (MapRow), each as many at a time as keep its lanes full: where rows are given piece by piece, the last points
// of one piece, which may take long, have those of the next for company.
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
  /// Takes what was given, and its points, ordered by row, layer, column; by any thread. Those not reached because of
  /// MapOptions::cancelled are not_run.
  using Done = std::function<void(int first, std::vector<MapPoint> points)>;

  /// `threads`: that will work. @throws as check_map.
  MapWork(const HybridSystem& system, const Vector& p, const ParameterGrid& grid, const std::vector<MapLayer>& layers,
          const MapOptions& options, int threads, Done done);
  MapWork(const MapWork&) = delete;
  MapWork& operator=(const MapWork&) = delete;

  /// `count` rows from row `first` on. @throws std::invalid_argument if the map does not have them.
  void give(int first, int count);
  /// Whether a thread would find something to do in rows given now. (Of one piece more than there are threads, or as many rows
  /// that are followed as twice fill its lanes, at the most: what is in work is lost if the program is killed.)
  bool wants_more() const;
  /// No more will be given: threads that find nothing to do need not wait.
  void close();
  /// By each thread: until it is closed and nothing is left to begin. @throws what a computation did, and ends the others.
  void work();

 private:
  using Mutex = oneapi::tbb::mutex;  // held for a few us at a time: whoever finds it taken does not sleep at once

  /// Rows that were given at once.
  struct Piece {
    int first;
    std::vector<MapPoint> points;
    std::size_t left;  ///< row_tasks
  };
  /// A row that is followed, or one point that waits for none.
  struct RowTask {
    const MapLayer* layer;
    int row, column;  ///< that of its first point
    MapRow points;
    std::shared_ptr<Piece> piece;
    MapRow::Next queued = MapRow::Next::likely;  ///< in row_tasks_, unlikely_, or neither
  };
  /// A point that was begun.
  struct Begun {
    std::shared_ptr<RowTask> row_task;
    std::shared_ptr<MapRow::Point> point;
  };

  std::optional<Begun> draw(std::size_t carried);
  bool has_some() const { return !row_tasks_.empty() || !unlikely_.empty(); }
  bool over() const { return failed_ || (closed_ && begun_ == 0 && !has_some()); }
  std::shared_ptr<RowTask> next(bool in_vain);
  void queue(const std::shared_ptr<RowTask>& row_task);
  MotionTask<> find(TaskSlot& lane, Begun begun);
  MotionTask<> find_point(TaskSlot& lane, const Begun& begun, MapPoint& out);
  void hand_on(const Begun& begun, const Vector& state);
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
  const bool followed_;  ///< some of the rows are
  AttractorOptions from_start_, from_neighbour_;
  Eigen::Index column_ = 0, row_ = 0;

  mutable Mutex mutex_;  ///< of all below
  std::condition_variable_any given_;
  WorkSharing exchange_{[this] {
    const std::lock_guard lock(mutex_);
    given_.notify_all();
  }};
  std::deque<std::shared_ptr<RowTask>> row_tasks_;  ///< ready to run
  std::deque<std::shared_ptr<RowTask>> unlikely_;   ///< ready, but their results will probably be rolled back
  std::size_t begun_ = 0;                           ///< points that are not ended
  std::size_t open_ = 0;                            ///< row_tasks that are not finished,
  std::size_t pieces_ = 0;                          ///< and pieces
  bool closed_ = false;
  std::atomic<bool> failed_ = false;
};

}  // namespace graze
