// SPDX-License-Identifier: GPL-3.0-or-later
// SweepWork: a sweep on its way, on several threads. Each carries some of its rows in SIMD lanes, and begins another one as soon
// as it can be begun: behind one that has handed its motion on, behind a guess (SweepStretches), or, on a smooth branch, when its
// orbit is found ahead. The result is the same on any number of threads.
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
  /// `so_far`: rows of an earlier run, which are kept. Keep the system alive. @throws as sweep().
  SweepWork(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
            const std::vector<SweepRow>& so_far);
  SweepWork(const SweepWork&) = delete;
  SweepWork& operator=(const SweepWork&) = delete;

  /// By each thread, until nothing is left to do. @throws what a computation did, and ends the others.
  void work();
  /// Direction by direction, up to the first that was not finished.
  std::vector<SweepRow> rows() &&;

 private:
  using Mutex = oneapi::tbb::mutex;  // held for a few us at a time: whoever finds it taken does not sleep at once
  using Lock = std::unique_lock<Mutex>;
  using Entry = SweepStretches::Entry;
  using Stretch = SweepStretches::Stretch;

  std::shared_ptr<Entry> draw(std::size_t carried);
  std::optional<std::shared_ptr<Entry>> go_on(std::size_t carried, Lock& lock);
  std::shared_ptr<Entry> next_row(SweepStretches& direction, Stretch& stretch, Lock& lock);
  bool look_ahead(SweepStretches& direction, Stretch& stretch, Lock& lock);
  MotionTask<> find(TaskSlot& lane, std::shared_ptr<Entry> entry);
  void hand_on(Entry& entry, const Vector& state);
  void finish(Entry& entry, SweepRow row);
  void tell(double value);
  void tell_news();
  bool cancelled() const { return failed_ || (options_.cancelled && options_.cancelled()); }

  const HybridSystem& system_;
  const SweepOptions options_;
  const std::size_t rows_of_a_thread_;  ///< fill its lanes

  Mutex mutex_;  ///< of all below, but for the chains of the directions
  std::deque<SweepStretches> directions_;
  std::condition_variable_any news_;
  WorkSharing exchange_{[this] {
    const std::lock_guard lock(mutex_);
    tell_news();
  }};
  std::size_t idle_ = 0;                 ///< threads that have nothing to do
  std::size_t threads_ = 0, begun_ = 0;  ///< and rows that they are at
  std::atomic<bool> failed_ = false;
};

}  // namespace graze
