// SPDX-License-Identifier: GPL-3.0-or-later
// RowRunner: computes the points of many rows on several threads. Each thread carries several motions, in SIMD lanes if these
// support the system, and starts another point as soon as one of a row can start (Row). The results do not depend on the number
// of threads.
#pragma once

#include <graze/floquet/follow/row.hpp>
#include <graze/lib/tasks/work_sharing.hpp>

#include <oneapi/tbb/mutex.h>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace graze {

struct RowRunnerOptions {
  FlowOptions flow = {};
  std::size_t threads = 1;  ///< that call RowRunner::work()
  /// Number of points that fills the lanes of a thread. With less than half of it, a thread also starts points that will
  /// probably be rolled back. Above it, others might finally have to wait for points of this thread.
  std::size_t enough = 32;
  std::size_t most = std::numeric_limits<std::size_t>::max();  ///< number of points of a thread
  std::function<bool()> cancelled = {};
};

class RowRunner {
 public:
  RowRunner(const SharedSystem& system, RowRunnerOptions options);
  RowRunner(const RowRunner&) = delete;
  RowRunner& operator=(const RowRunner&) = delete;

  void give(const std::vector<std::shared_ptr<Row>>& rows);
  /// No more rows will follow: idle threads stop waiting.
  void close();
  /// Number of rows whose next point can start and will probably be kept.
  std::size_t ready() const;
  /// Run by each thread: works until it is closed and nothing is left to do. @throws the exception of a computation, and ends
  /// the other threads.
  void work();

 private:
  using Mutex = oneapi::tbb::mutex;  // held for a few us at a time: spin before sleeping
  using Lock = std::unique_lock<Mutex>;
  using Queue = std::deque<std::shared_ptr<Row>>;

  /// A started point.
  struct Started {
    std::shared_ptr<Row> row;
    std::shared_ptr<Row::Entry> entry;
  };

  std::optional<Started> draw(std::size_t carried);
  bool has_some() const { return !likely_.empty() || !guesses_.empty() || !unlikely_.empty(); }
  bool over() const { return failed_ || (closed_ && open_ == 0 && !has_some()); }
  std::size_t share() const;
  Queue& queue_of(Row::Next next);
  std::shared_ptr<Row> next(bool speculative);
  void queue(const std::shared_ptr<Row>& row);
  std::optional<Started> start(const std::shared_ptr<Row>& row, Lock& lock);
  bool predict(const std::shared_ptr<Row>& row, Row::Stretch& stretch, Lock& lock);
  MotionTask<> find(TaskSlot& slot, Started started);
  std::optional<Started> finish(const Started& started, RowChain::Found found);
  void tell(Lock& lock);
  bool cancelled() const { return failed_ || (options_.cancelled && options_.cancelled()); }

  const SharedSystem system_;
  const RowRunnerOptions options_;

  mutable Mutex mutex_;  ///< guards all members below and the rows, except their chains
  std::condition_variable_any news_;
  WorkSharing exchange_{[this] {
    const std::lock_guard lock(mutex_);
    news_.notify_all();
  }};
  Queue likely_, unlikely_, guesses_;  ///< rows whose next point can start, by Row::next()
  std::size_t open_ = 0;               ///< points and predictions in progress
  Queue untold_;                       ///< finished rows whose listeners have not been told
  bool closed_ = false;
  std::atomic<bool> failed_ = false;
};

}  // namespace graze
