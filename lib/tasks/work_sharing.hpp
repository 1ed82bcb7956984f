// SPDX-License-Identifier: GPL-3.0-or-later
// WorkSharing: where the pools of several threads hand computations over: one that has nothing left to do is given half of what
// another carries, or, where that is one computation of many motions, some of these for a while. (What comes out of a computation
// does not depend on who carries it.)
#pragma once

#include <graze/lib/tasks/task_pool.hpp>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <vector>

namespace graze {

class WorkSharing {
 public:
  /// `wake` is called, by any thread, when there is something for those that wait.
  explicit WorkSharing(std::function<void()> wake);
  WorkSharing(const WorkSharing&) = delete;
  WorkSharing& operator=(const WorkSharing&) = delete;
  ~WorkSharing();

  /// A thread whose pool has nothing to do waits, and no more.
  void begin_waiting() { ++waiting_; }
  void end_waiting() { --waiting_; }
  /// Whether there is something for it.
  bool has_some() const { return has_some_; }
  /// Nothing is left to begin: pools that have nothing end.
  void close() { closed_ = true; }

 private:
  friend class TaskPool;
  struct MovedTask;
  using SharedRuns = TaskPool::SharedRuns;
  using Part = TaskPool::Part;
  std::size_t waiting() const { return static_cast<std::size_t>(waiting_); }
  bool wants() const { return waiting_ > 0 && !has_some_; }
  void put(std::vector<MovedTask> parcels);
  std::vector<MovedTask> get();
  /// Offers motions to others. False: those of another pool are on offer.
  bool lend(SharedRuns& motions);
  /// Of those on offer, or of these, a part that nobody has; null: there is none.
  Part take_part(SharedRuns* of = nullptr);
  void give_back(const Part& part, std::exception_ptr error);
  void wait_for_all(const SharedRuns& motions);

  const std::function<void()> wake_;
  std::atomic<int> waiting_ = 0;
  std::atomic<bool> has_some_ = false, closed_ = false;
  std::mutex mutex_;
  std::vector<MovedTask> parcels_;
  SharedRuns* lent_ = nullptr;  ///< on offer: there are parts that nobody has
  std::condition_variable given_back_;
};

}  // namespace graze
