// SPDX-License-Identifier: GPL-3.0-or-later
// LaneExchange: where the pools of several threads hand computations over: one that has nothing left to do is given half of what
// another carries. (What comes out of a computation does not depend on who carries it.)
#pragma once

#include <graze/lib/lane_pool.hpp>

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace graze {

class LaneExchange {
 public:
  /// `wake` is called, by any thread, when there is something for those that wait.
  explicit LaneExchange(std::function<void()> wake);
  LaneExchange(const LaneExchange&) = delete;
  LaneExchange& operator=(const LaneExchange&) = delete;
  ~LaneExchange();

  /// A thread whose pool has nothing to do waits, and no more.
  void begin_waiting() { ++waiting_; }
  void end_waiting() { --waiting_; }
  /// Whether there is something for it.
  bool has_some() const { return has_some_; }

 private:
  friend class LanePool;
  struct Parcel;
  bool wants() const { return waiting_ > 0 && !has_some_; }
  void put(std::vector<Parcel> parcels);
  std::vector<Parcel> get();

  const std::function<void()> wake_;
  std::atomic<int> waiting_ = 0;
  std::atomic<bool> has_some_ = false;
  std::mutex mutex_;
  std::vector<Parcel> parcels_;
};

}  // namespace graze
