// SPDX-License-Identifier: GPL-3.0-or-later
// TaskPool: many computations that share the SIMD lanes of a thread (LaneCarrier), each at its own pace. Where one takes long,
// the others do not wait for it, and its motion has their company. The pools of several threads may hand them over to each other
// (lane_exchange.hpp).
#pragma once

#include <graze/lib/motion/lane_carrier.hpp>
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

/// A computation's place in a pool: what it asks for, and what it is given.
class TaskSlot {
 public:
  explicit TaskSlot(TaskPool& pool) : pool_(&pool) {}

  /// The parameters of its motions from now on. @throws std::invalid_argument where LaneCarrier does not apply.
  void take_parameters(const Vector& p);
  /// The same, known to LaneCarrier already.
  void take_parameters(std::size_t known) { parameters_ = known; }
  std::size_t parameters() const { return parameters_; }
  LaneCarrier& motions() const;
  MotionStart at(const Vector& state) const { return {parameters_, state[0], state[1]}; }
  /// Whether others wait for what it does: it is carried each time, also where there are few of its kind.
  void hurry(bool others_wait) { hurries_ = others_wait; }

  class Carrying;
  /// co_await: what `periods` forcing periods did to these motions, at the parameters of the place, as in LaneCarrier::carry;
  /// good until the next time.
  Carrying carry(std::span<const MotionStart> motions, std::size_t periods, bool tangent);
  Carrying carry(const Vector& state, std::size_t periods, ImpactSpeeds* speeds = nullptr);

 private:
  friend class TaskPool;
  struct Run : MotionRun {
    TaskSlot* place = nullptr;
  };
  void resume();

  TaskPool* pool_;
  std::optional<std::size_t> own_parameters_;
  Vector own_;
  std::size_t parameters_ = 0;
  bool tangent_ = false, hurries_ = false;
  std::size_t asked_for_ = 0;  ///< forcing periods, all in all
  std::vector<PeriodResult> results_;
  std::vector<Run> runs_;  ///< asked for
  std::size_t open_ = 0;   ///< of them, those that are not through
  std::coroutine_handle<> waiting_;
};

class TaskSlot::Carrying {
 public:
  explicit Carrying(TaskSlot& place) : place_(place) {}
  bool await_ready() const noexcept { return place_.results_.empty(); }
  void await_suspend(std::coroutine_handle<> waiting) const noexcept { place_.waiting_ = waiting; }
  std::span<const PeriodResult> await_resume() const noexcept { return place_.results_; }

 private:
  TaskSlot& place_;
};

class TaskPool : RunSupply {
 public:
  /// Keep them alive.
  explicit TaskPool(LaneCarrier& motions, WorkSharing* exchange = nullptr);

  /// Carries computations to their ends. As long as there is room, the next is asked for: next(its place, how many are carried);
  /// nullopt: there is none now, or, where none is carried and there is no exchange or it is closed, no more. @throws what the
  /// first of them to throw did.
  void run(const std::function<std::optional<MotionTask<>>(TaskSlot&, std::size_t carried)>& next);
  /// The same of make(0, its place) ... make(count - 1, its place).
  void run(std::size_t count, const std::function<MotionTask<>(std::size_t, TaskSlot&)>& make);

 private:
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
  std::size_t set_for(const SharedRuns& lent);
  static const TaskSlot* longest_of(std::span<const std::unique_ptr<Member>> members);
  bool hurries(const TaskSlot& place) const { return place.hurries_ || &place == longest_; }
  std::optional<std::size_t> free_place();
  void put_down(const Vector& p, std::optional<std::size_t>& place);
  void clear(TaskSlot& place);
  void carry(std::span<const std::unique_ptr<Member>> members, bool tangent, std::size_t motions);
  void go_on_with(TaskSlot::Run& run, std::size_t periods);

  LaneCarrier& motions_;
  WorkSharing* exchange_;
  std::vector<std::size_t> free_parameters_;  ///< parameter sets that nobody has
  std::vector<MotionRun*> runs_;              ///< of a turn, at its beginning
  std::optional<std::size_t> of_others_;      ///< a parameter set for motions that others share
  std::vector<MotionRun> shared_;             ///< those of them that it carries
  const TaskSlot* longest_ = nullptr;         ///< the computation that goes first
  bool tangent_ = false;                      ///< of a turn
  std::size_t share_ = 0, left_ = 0;          ///< periods of each motion at a time; of all of them, before it ends
};

}  // namespace graze
