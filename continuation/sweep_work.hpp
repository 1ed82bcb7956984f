// SPDX-License-Identifier: GPL-3.0-or-later
// SweepWork: a sweep on its way, on several threads. Each carries some of its rows in SIMD lanes, and goes on to the next row as
// soon as one before it has handed its motion on (SweepChain), or, on a smooth branch, as soon as its orbit is found ahead.
//
// Should a motion that was handed on end on a stable orbit after all, the rows behind it are taken back and computed again, from
// that orbit. So the result is that of one row after the other, on any number of threads.
#pragma once

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
    SweepRow row;  ///< its end is where the next one begins, once it is handed on
    Way* way;
    SweepChain::Begin begin;
    bool handed_on = false;  ///< the next row may begin
    bool done = false;
    std::atomic<bool> dropped = false;  ///< a row before it has turned out another
  };
  /// One direction.
  struct Way {
    SweepChain chain;
    std::vector<std::shared_ptr<Entry>> entries;
    bool looks_ahead = false;    ///< a thread does so
    bool ended = false;          ///< the motion could not be carried on
    std::size_t open = 0;        ///< rows that are not done
    std::size_t first_open = 0;  ///< before it there are none
    std::size_t taken_back = 0;  ///< how often
  };

  std::shared_ptr<Entry> draw(std::size_t carried);
  Way* next_way(std::size_t carried);
  bool far_ahead_of_open(Way& way) const;
  bool look_ahead(Way& way, std::unique_lock<std::mutex>& lock);
  std::shared_ptr<Entry> next_row(Way& way, std::unique_lock<std::mutex>& lock);
  LaneTask<> find(LanePlace& lane, std::shared_ptr<Entry> entry);
  void hand_on(Entry& entry, const Vector& state);
  void finish(Entry& entry, SweepRow row);
  void take_back(Way& way, std::size_t from);
  void tell(double value);
  bool goes_on(const Way& way) const;
  bool cancelled() const { return failed_ || (options_.cancelled && options_.cancelled()); }

  const HybridSystem& system_;
  const SweepOptions options_;
  const std::size_t rows_of_a_thread_;  ///< fill its lanes
  std::deque<Way> ways_;

  std::mutex mutex_;  ///< of all below, and of what the ways have but for their chains
  std::condition_variable news_;
  LaneExchange exchange_{[this] {
    const std::lock_guard lock(mutex_);
    news_.notify_all();
  }};
  std::size_t idle_ = 0;                 ///< threads that have nothing to do
  std::size_t threads_ = 0, begun_ = 0;  ///< and rows that they are at
  std::size_t done_ = 0;                 ///< rows
  std::atomic<bool> failed_ = false;
};

}  // namespace graze
