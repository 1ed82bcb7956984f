// SPDX-License-Identifier: GPL-3.0-or-later
// SweepWork: a sweep on its way, on several threads. Some follow the motion from value to value, one at a time for each
// direction; what is not periodic is left behind to wait for the rest of its transient, its samples and time averages, which the
// threads carry out for many rows side by side in SIMD lanes.
//
// Should a motion that was left behind end on a stable orbit after all, the rows behind it are taken back and computed again,
// from that orbit. So the result is that of one row after the other, on any number of threads.
#pragma once

#include <graze/continuation/orbits_ahead.hpp>
#include <graze/continuation/sweep_chain.hpp>
#include <graze/lib/lane_exchange.hpp>

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
  struct Way;
  struct Entry {
    SweepRow row;
    Way* way;
    std::size_t number;      ///< in its direction
    int transient_left = 0;  ///< forcing periods
    bool done = false;
    std::atomic<bool> dropped = false;  ///< a row before it has turned out another
  };
  /// One direction.
  struct Way {
    SweepChain chain;
    std::vector<std::shared_ptr<Entry>> entries;
    std::deque<std::shared_ptr<Entry>> waiting;  ///< to be begun
    bool followed = false;                       ///< by a thread
    bool ended = false;                          ///< the motion could not be carried on
    std::size_t open = 0;                        ///< rows that are not done
    std::size_t taken_back = 0;                  ///< how often
  };

  std::shared_ptr<Entry> draw(std::size_t carried);
  std::shared_ptr<Entry> next_waiting();
  Way* to_follow(std::size_t carried);
  bool far_ahead_of_open(const Way& way) const;
  void follow(Way& way, std::unique_lock<std::mutex>& lock);
  SweepChain::Before before_next(const Way& way) const;
  LaneTask<> settle(LanePlace& lane, std::shared_ptr<Entry> entry);
  LaneTask<> sample(LanePlace& lane, const SweepChain& chain, SweepRow& row) const;
  void finish(Entry& entry, SweepRow row);
  void take_back(Way& way, std::size_t from);
  void tell(double value);
  bool goes_on(const Way& way) const;
  bool cancelled() const { return failed_ || (options_.cancelled && options_.cancelled()); }

  const HybridSystem& system_;
  const SweepOptions options_;
  const std::size_t enough_;  ///< rows fill the lanes of a thread
  std::deque<Way> ways_;

  std::mutex mutex_;  ///< of all below, and of what the ways have but for their chains
  std::condition_variable news_;
  LaneExchange exchange_{[this] {
    const std::lock_guard lock(mutex_);
    news_.notify_all();
  }};
  std::size_t rows_of_a_thread_;  ///< at a time: the fewer, the more rows have been taken back lately
  std::size_t idle_ = 0;          ///< threads that have nothing to do
  std::size_t begun_ = 0;         ///< rows that the threads are at
  std::size_t done_ = 0;          ///< rows
  std::atomic<bool> failed_ = false;
};

}  // namespace graze
