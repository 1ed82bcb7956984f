// SPDX-License-Identifier: GPL-3.0-or-later
// SweepWork: computes a sweep on several threads. Each thread carries several rows in SIMD lanes and starts another as soon as
// possible: after a row that has published its state, after a guess (SweepStretches), or, on a smooth branch, once its orbit is
// predicted. The result does not depend on the number of threads.
#pragma once

#include <graze/floquet/follow/sweep_stretches.hpp>
#include <graze/lib/tasks/work_sharing.hpp>

#include <oneapi/tbb/mutex.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace graze {

class SweepWork {
 public:
  /// `so_far`: rows of an earlier run, which are kept. The caller keeps the system alive. @throws as sweep().
  SweepWork(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
            const std::vector<SweepRow>& so_far);
  SweepWork(const SweepWork&) = delete;
  SweepWork& operator=(const SweepWork&) = delete;

  /// Run by each thread until nothing is left to do. @throws the exception of a computation, and ends the other threads.
  void work();
  /// The rows, direction by direction, up to the first that is not finished.
  std::vector<SweepRow> rows() &&;

 private:
  using Mutex = oneapi::tbb::mutex;  // held for a few us at a time: spin before sleeping
  using Lock = std::unique_lock<Mutex>;
  using Entry = SweepStretches::Entry;
  using Stretch = SweepStretches::Stretch;

  std::shared_ptr<Entry> draw(std::size_t carried);
  std::optional<std::shared_ptr<Entry>> go_on(std::size_t carried, Lock& lock);
  std::shared_ptr<Entry> next_row(SweepStretches& direction, Stretch& stretch, Lock& lock);
  bool look_ahead(SweepStretches& direction, Stretch& stretch, Lock& lock);
  MotionTask<> find(TaskSlot& lane, std::shared_ptr<Entry> entry);
  void publish(Entry& entry, const Vector& state);
  void finish(Entry& entry, SweepRow row);
  void tell(double value);
  void tell_news();
  bool cancelled() const { return failed_ || (options_.cancelled && options_.cancelled()); }

  const HybridSystem& system_;
  const SweepOptions options_;
  const std::size_t rows_of_a_thread_;  ///< number that fills its lanes

  Mutex mutex_;  ///< guards all members below, except the chains of the directions
  std::deque<SweepStretches> directions_;
  std::condition_variable_any news_;
  WorkSharing exchange_{[this] {
    const std::lock_guard lock(mutex_);
    tell_news();
  }};
  std::size_t idle_ = 0;                 ///< waiting threads
  std::size_t threads_ = 0, begun_ = 0;  ///< working threads, and rows in progress
  std::atomic<bool> failed_ = false;
};

}  // namespace graze
