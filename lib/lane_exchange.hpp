// SPDX-License-Identifier: GPL-3.0-or-later
// LaneExchange: where the pools of several threads hand computations over: one that has nothing left to do is given half of what
// another carries, or, where that is one computation of many motions, some of these for a while. (What comes out of a computation
// does not depend on who carries it.)
#pragma once

#include <graze/lib/lane_pool.hpp>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
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
  /// Nothing is left to begin: pools that have nothing end.
  void close() { closed_ = true; }

 private:
  friend class LanePool;
  struct Parcel;
  using Lent = LanePool::Lent;
  using Part = LanePool::Part;
  std::size_t waiting() const { return static_cast<std::size_t>(waiting_); }
  bool wants() const { return waiting_ > 0 && !has_some_; }
  void put(std::vector<Parcel> parcels);
  std::vector<Parcel> get();
  /// Offers motions to others. False: those of another pool are on offer.
  bool lend(Lent& motions);
  /// Of those on offer, or of these, a part that nobody has; null: there is none.
  Part take_part(Lent* of = nullptr);
  void give_back(const Part& part, std::exception_ptr error);
  void wait_for_all(const Lent& motions);

  const std::function<void()> wake_;
  std::atomic<int> waiting_ = 0;
  std::atomic<bool> has_some_ = false, closed_ = false;
  std::mutex mutex_;
  std::vector<Parcel> parcels_;
  Lent* lent_ = nullptr;  ///< on offer: there are parts that nobody has
  std::condition_variable given_back_;
};

}  // namespace graze
