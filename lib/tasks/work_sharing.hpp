// SPDX-License-Identifier: GPL-3.0-or-later
// WorkSharing: exchange of tasks between the pools of several threads. An idle pool receives half of the tasks of another pool
// or, if that pool has a single task with many motions, a part of these for a while. (The result of a task does not depend on
// the pool that runs it.)
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
  /// `wake` is called, by any thread, when there is work for the waiting threads.
  explicit WorkSharing(std::function<void()> wake);
  WorkSharing(const WorkSharing&) = delete;
  WorkSharing& operator=(const WorkSharing&) = delete;
  ~WorkSharing();

  /// A thread with an idle pool does nothing but wait between these two calls.
  void begin_waiting() { ++waiting_; }
  void end_waiting() { --waiting_; }
  /// Whether there is work for a waiting thread.
  bool has_some() const { return has_some_; }
  /// No further task will begin: idle pools end.
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
  /// Offers runs to other pools. False: an offer of another pool is open.
  bool lend(SharedRuns& motions);
  /// Takes an untaken part of `of`, or of the runs on offer. A null part means that there is none.
  Part take_part(SharedRuns* of = nullptr);
  void give_back(const Part& part, std::exception_ptr error);
  void wait_for_all(const SharedRuns& motions);

  const std::function<void()> wake_;
  std::atomic<int> waiting_ = 0;
  std::atomic<bool> has_some_ = false, closed_ = false;
  std::mutex mutex_;
  std::vector<MovedTask> parcels_;
  SharedRuns* lent_ = nullptr;  ///< runs on offer: some parts are not taken
  std::condition_variable given_back_;
};

}  // namespace graze
