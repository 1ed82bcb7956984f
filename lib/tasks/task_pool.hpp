// SPDX-License-Identifier: GPL-3.0-or-later
// TaskPool: runs many tasks that share the SIMD lanes of one thread (LaneCarrier), each at its own pace. A long task does not
// hold up the others, and its motion shares the lanes with theirs. The pools of several threads may exchange tasks
// (work_sharing.hpp). Motions that the lanes do not support are carried by a Propagator at once, so that a task is written in
// the same way for any system.
#pragma once

#include <graze/lib/tasks/carried_periods.hpp>
#include <graze/lib/tasks/task.hpp>

#include <coroutine>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace graze {

class TaskPool;
class WorkSharing;

/// A task's slot in a pool: its requests and their results.
class TaskSlot {
 public:
  explicit TaskSlot(TaskPool& pool) : pool_(&pool) {}

  /// Sets the parameters of its motions from now on. They are carried in lanes if LaneCarrier applies there and `alone` is
  /// false; otherwise by a Propagator.
  void set_parameters(const Vector& p, bool alone = false);
  const Vector& p() const { return alone_ ? propagator().parameters() : own_; }
  bool in_lanes() const { return !alone_; }
  /// Carries its motions if they are not carried in lanes.
  Propagator& propagator() const { return *propagators_.front(); }
  std::size_t parameters() const { return parameters_; }
  LaneCarrier& motions() const;
  /// LaneCarrier::expect and use for its motions; without effect if they are not carried in lanes.
  void expect(std::int64_t periods) const;
  void use(std::shared_ptr<const ContactTable> table) const;
  /// Number of periods of each motion to request at once, `most` of them in lanes. By Propagators it is small: a task that ends
  /// has no use for the rest of its request, and longer requests make the motions no faster.
  std::size_t batch(std::size_t most, std::size_t motions = 1) const;
  /// Number of its motions that one thread carries at once (graze::motions_at_once).
  std::size_t motions_at_once() const;
  /// Whether all threads of the caller's arena may work for the task.
  bool all_threads() const;
  /// Of all motions of the pool, with their options.
  const SharedSystem& system() const;
  const FlowOptions& flow() const;
  MotionStart at(const Vector& state) const { return {parameters_, state[0], state[1]}; }
  /// Sets whether others wait for its result: the task is then served every round, even in a small batch.
  void hurry(bool others_wait) { urgent_ = others_wait; }

  class Carrying;
  class CarryingOne;
  class CarryingSome;
  /// co_await: the results of `periods` forcing periods of these motions in lanes at the slot's parameters, in the order of
  /// LaneCarrier::carry. They are valid until the next request.
  Carrying carry(std::span<const MotionStart> motions, std::size_t periods, bool tangent);
  /// co_await: the next `periods` periods of the motion from `state`, in lanes or not.
  CarryingOne carry(const Vector& state, std::size_t periods, ImpactSpeeds* speeds = nullptr);
  /// The same with tangent.
  CarryingOne carry_with_tangent(const Vector& state, std::size_t periods);
  /// The same of the motions from each of these states.
  CarryingSome carry_all(const std::vector<Vector>& states, std::size_t periods, bool tangent);
  /// co_await: one forcing period with tangent from each node of an orbit, the columns of `nodes`. `modes`: those at the nodes
  /// the last time (TransitionOptions::held_mode); they are brought up to date.
  CarryingOne carry_nodes(const Matrix& nodes, std::vector<std::optional<std::size_t>>& modes);
  /// The periods of the last request for a state, states or nodes.
  CarriedPeriods carried() const;

 private:
  friend class TaskPool;
  struct Run : MotionRun {
    TaskSlot* place = nullptr;
  };
  void resume();
  void carry_some(std::span<const Vector> states, std::size_t periods, bool tangent, ImpactSpeeds* speeds);
  void carry_alone(std::span<const Vector> states, std::size_t periods, bool tangent, ImpactSpeeds* speeds);
  void carry_nodes_alone(const Matrix& nodes, std::vector<std::optional<std::size_t>>& modes);

  TaskPool* pool_;
  bool alone_ = false;                                    ///< its motions are not carried in lanes
  std::vector<std::unique_ptr<Propagator>> propagators_;  ///< of the first motion, the second ...; made when needed
  std::vector<Transition> ends_;                          ///< of the present request, if not in lanes
  std::optional<std::size_t> own_parameters_;
  Vector own_;
  std::size_t parameters_ = 0;
  bool tangent_ = false, urgent_ = false;
  std::size_t requested_periods_ = 0;  ///< forcing periods requested so far
  std::vector<PeriodResult> results_;
  std::vector<MotionStart> starts_;
  std::vector<Run> runs_;  ///< of the present request
  std::size_t open_ = 0;   ///< unfinished runs
  std::coroutine_handle<> waiting_;
};

class TaskSlot::Carrying {
 public:
  explicit Carrying(TaskSlot& place) : place_(place) {}
  bool await_ready() const noexcept { return place_.results_.empty(); }
  void await_suspend(std::coroutine_handle<> waiting) const noexcept { place_.waiting_ = waiting; }
  std::span<const PeriodResult> await_resume() const noexcept { return place_.results_; }

 protected:
  TaskSlot& place_;
};

class TaskSlot::CarryingOne : public Carrying {
 public:
  using Carrying::Carrying;
  CarriedPeriods await_resume() const noexcept { return place_.carried(); }
};

class TaskSlot::CarryingSome : public Carrying {
 public:
  CarryingSome(TaskSlot& place, std::size_t periods) : Carrying(place), periods_(periods) {}
  CarriedMotions await_resume() const noexcept { return {place_.carried(), periods_}; }

 private:
  std::size_t periods_;
};

class TaskPool : RunSupply {
 public:
  /// Of motions of this system. Refers to `exchange`.
  explicit TaskPool(const SharedSystem& system, const FlowOptions& options = {}, WorkSharing* exchange = nullptr);
  /// Refers to both.
  explicit TaskPool(LaneCarrier& motions, WorkSharing* exchange = nullptr);

  /// Runs tasks to their ends. Calls next(slot, running tasks) while slots are free. nullopt means "none now"; if nothing is
  /// running and there is no work sharing or it is closed, it means "done". @throws the exception of the first task that
  /// throws.
  void run(const std::function<std::optional<MotionTask<>>(TaskSlot&, std::size_t carried)>& next);
  /// Runs the tasks make(0, slot) ... make(count - 1, slot).
  void run(std::size_t count, const std::function<MotionTask<>(std::size_t, TaskSlot&)>& make);
  /// From now on, several motions of a task are distributed over all threads of the caller's arena.
  void use_all_threads();

 private:
  TaskPool(std::unique_ptr<LaneCarrier> own, WorkSharing* exchange);
  friend class TaskSlot;
  friend class WorkSharing;
  struct Member;
  struct SharedRuns;
  struct Part;
  void give(std::vector<std::unique_ptr<Member>>& members);
  void take(std::vector<std::unique_ptr<Member>>& members);
  bool lend(TaskSlot& place);
  void help();
  void carry_part(const Part& part);
  void carry_rest(std::span<const TaskSlot::Run> runs, std::size_t set, bool tangent);
  bool carry_only(TaskSlot& place);
  std::size_t set_for(const SharedRuns& lent);
  static const TaskSlot* longest_task(std::span<const std::unique_ptr<Member>> members);
  bool hurries(const TaskSlot& place) const { return place.urgent_ || &place == longest_; }
  std::optional<std::size_t> unused_set();
  void store_parameters(const Vector& p, std::optional<std::size_t>& place);
  void clear(TaskSlot& place);
  void carry(std::span<const std::unique_ptr<Member>> members, bool tangent, std::size_t motions);
  void feed_lanes(TaskSlot::Run& run, std::size_t periods);

  friend void run_alone(const SharedSystem& system, const FlowOptions& options,
                        const std::function<MotionTask<>(TaskSlot&)>& make);

  std::unique_ptr<LaneCarrier> own_;  ///< the carrier, if it is the pool's own
  LaneCarrier& motions_;
  WorkSharing* exchange_;
  bool alone_ = false;                        ///< the motions are not carried in lanes
  bool all_threads_ = false;                  ///< they are distributed over all threads
  std::vector<std::size_t> free_parameters_;  ///< indices of unused parameter sets
  std::vector<MotionRun*> runs_;              ///< at the beginning of a turn
  std::optional<std::size_t> shared_set_;     ///< parameter set for runs that another pool shares
  std::vector<MotionRun> rest_;               ///< runs that are carried to their ends
  const TaskSlot* longest_ = nullptr;         ///< slot of the task that goes first
  bool tangent_ = false;                      ///< of the present turn
  std::size_t share_ = 0, left_ = 0;          ///< quotas of periods: of each run at a time, and left to all runs in the turn
};

/// Runs the tasks make(0, slot) ... make(count - 1, slot) on pools of their own: one, or one for each thread of the caller's
/// arena. (All threads may carry the motions of a single task.) The results do not depend on it.
void run_tasks(const SharedSystem& system, const FlowOptions& options, bool all_threads, std::size_t count,
               const std::function<MotionTask<>(std::size_t, TaskSlot&)>& make);

/// Runs one task by itself; its motions are carried by a Propagator.
void run_alone(const SharedSystem& system, const FlowOptions& options, const std::function<MotionTask<>(TaskSlot&)>& make);

}  // namespace graze
