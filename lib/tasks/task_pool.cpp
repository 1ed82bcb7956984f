// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/numerics/parallel.hpp>
#include <graze/lib/tasks/pool_member.hpp>
#include <graze/lib/tasks/work_sharing.hpp>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

namespace graze {

namespace {

/// Number of tasks in a pool: enough to keep the lanes full, even if many request a single period.
constexpr std::size_t together = 128;
/// A kind (with or without tangent) with at least this many runs is served every round; a smaller one only when it is the
/// larger of the two.
constexpr std::size_t busy = 48;
/// Quotas of a turn: periods of all runs together, and bounds of those of each run.
constexpr std::size_t work_of_turn = 512, fewest_periods = 4, most_periods = 32;
/// A task with more forcing periods than this is probably a long one. The longest of these goes first, so that the pool need
/// not wait for it alone in the end.
constexpr std::size_t long_computation = 4096;
/// Periods of each of several motions by Propagators that make threads worth while.
constexpr std::size_t work_for_thread = 8;

}  // namespace

LaneCarrier& TaskSlot::motions() const { return pool_->motions_; }

const SharedSystem& TaskSlot::system() const { return motions().system(); }

const FlowOptions& TaskSlot::flow() const { return motions().options(); }

void TaskSlot::set_parameters(const Vector& p, bool alone) {
  const LaneCarrier& lanes = motions();
  alone_ = alone || pool_->alone_ || !LaneCarrier::applies(lanes.system(), p, lanes.options());
  if (alone_) {
    if (propagators_.empty() || propagators_.front()->parameters() != p) {
      propagators_.clear();
      propagators_.push_back(std::make_unique<Propagator>(lanes.system(), p, std::vector<std::size_t>{}, lanes.options()));
    }
    results_.clear();
    return;
  }
  if (!own_parameters_ || p != own_) {
    pool_->store_parameters(p, own_parameters_);
    own_ = p;
  }
  parameters_ = *own_parameters_;
}

void TaskSlot::expect(std::int64_t periods) const {
  if (!alone_) motions().expect(parameters_, periods);
}

void TaskSlot::use(std::shared_ptr<const ContactTable> table) const {
  if (!alone_) motions().use(parameters_, std::move(table));
}

std::size_t TaskSlot::batch(std::size_t most, std::size_t motions) const {
  if (!alone_) return most;
  return std::min<std::size_t>(most, motions > 1 ? work_for_thread : 1);
}

std::size_t TaskSlot::motions_at_once() const { return alone_ ? 1 : motions_in_lanes; }

bool TaskSlot::all_threads() const { return pool_->all_threads_; }

TaskSlot::Carrying TaskSlot::carry(std::span<const MotionStart> motions, std::size_t periods, bool tangent) {
  tangent_ = tangent;
  results_.resize(motions.size() * periods);
  runs_.clear();
  for (std::size_t m = 0; m < motions.size(); ++m)
    runs_.push_back({{{parameters_, motions[m].x, motions[m].v}, periods, &results_[m * periods]}, this});
  open_ = periods > 0 ? runs_.size() : 0;
  requested_periods_ += periods;
  return Carrying(*this);
}

TaskSlot::CarryingOne TaskSlot::carry(const Vector& state, std::size_t periods, ImpactSpeeds* speeds) {
  carry_some({&state, 1}, periods, false, speeds);
  return CarryingOne(*this);
}

TaskSlot::CarryingOne TaskSlot::carry_with_tangent(const Vector& state, std::size_t periods) {
  carry_some({&state, 1}, periods, true, nullptr);
  return CarryingOne(*this);
}

TaskSlot::CarryingSome TaskSlot::carry_all(const std::vector<Vector>& states, std::size_t periods, bool tangent) {
  carry_some(states, periods, tangent, nullptr);
  return {*this, periods};
}

TaskSlot::CarryingOne TaskSlot::carry_nodes(const Matrix& nodes, std::vector<std::optional<std::size_t>>& modes) {
  if (alone_) {
    carry_nodes_alone(nodes, modes);
  } else {
    starts_.clear();
    for (const auto& node : nodes.colwise()) starts_.push_back({parameters_, node[0], node[1]});
    carry(starts_, 1, true);
  }
  return CarryingOne(*this);
}

/// `speeds`: of the first motion.
void TaskSlot::carry_some(std::span<const Vector> states, std::size_t periods, bool tangent, ImpactSpeeds* speeds) {
  if (alone_) return carry_alone(states, periods, tangent, speeds);
  starts_.clear();
  for (const Vector& state : states) starts_.push_back(at(state));
  carry(starts_, periods, tangent);
  runs_.front().speeds = speeds;
}

/// Carries each motion by its own Propagator.
void TaskSlot::carry_alone(std::span<const Vector> states, std::size_t periods, bool tangent, ImpactSpeeds* speeds) {
  const TransitionOptions options{.sensitivity = tangent ? Sensitivity::state : Sensitivity::none,
                                  .keep_events = speeds != nullptr};
  const Vector& p = propagator().parameters();
  while (propagators_.size() < states.size())
    propagators_.push_back(std::make_unique<Propagator>(system(), p, std::vector<std::size_t>{}, flow()));
  ends_.resize(states.size() * periods);
  const auto carry_motion = [&](std::size_t motion) {
    const std::span<Transition> ends(ends_.data() + motion * periods, periods);
    for (std::size_t k = 0; k < periods; ++k) {
      carry_period(*propagators_[motion], k == 0 ? states[motion] : ends[k - 1].x1, options, ends[k]);
      if (ends[k].termination == Termination::time) continue;
      for (Transition& later : ends.subspan(k + 1)) later.termination = ends[k].termination;
      return;
    }
  };
  for_each_index(all_threads(), states.size(), carry_motion);
  if (!speeds) return;
  for (const Transition& period : ends_)
    if (period.termination == Termination::time) record_contacts(period.events, *speeds);
}

/// One Propagator carries all nodes, up to the first that fails.
void TaskSlot::carry_nodes_alone(const Matrix& nodes, std::vector<std::optional<std::size_t>>& modes) {
  TransitionOptions options{.sensitivity = Sensitivity::state};
  ends_.resize(static_cast<std::size_t>(nodes.cols()));
  modes.resize(ends_.size());
  for (std::size_t k = 0; k < ends_.size(); ++k) {
    options.held_mode = modes[k];
    carry_period(propagator(), nodes.col(static_cast<Eigen::Index>(k)), options, ends_[k]);
    if (ends_[k].termination != Termination::time) {
      for (Transition& later : std::span(ends_).subspan(k + 1)) later.termination = ends_[k].termination;
      return;
    }
    modes[k] = ends_[k].mode0;
  }
}

CarriedPeriods TaskSlot::carried() const {
  if (!alone_) return CarriedPeriods(results_);
  return {ends_, system()};
}

/// Resumes the task with its results.
void TaskSlot::resume() {
  runs_.clear();
  motions().make_pending_table(parameters_);
  waiting_.resume();
}

TaskPool::TaskPool(const SharedSystem& system, const FlowOptions& options, WorkSharing* exchange)
    : TaskPool(std::make_unique<LaneCarrier>(system, options), exchange) {}

TaskPool::TaskPool(std::unique_ptr<LaneCarrier> own, WorkSharing* exchange) : TaskPool(*own, exchange) { own_ = std::move(own); }

TaskPool::TaskPool(LaneCarrier& motions, WorkSharing* exchange) : motions_(motions), exchange_(exchange) {
  through = [](RunSupply& self, MotionRun& run, std::size_t periods) {
    static_cast<TaskPool&>(self).feed_lanes(static_cast<TaskSlot::Run&>(run), periods);
  };
}

/// The index of an unused parameter set, if there is one.
std::optional<std::size_t> TaskPool::unused_set() {
  if (free_parameters_.empty()) return std::nullopt;
  const std::size_t place = free_parameters_.back();
  free_parameters_.pop_back();
  return place;
}

/// Stores the parameters in the set `place` or, if there is none, in an unused or a new set.
void TaskPool::store_parameters(const Vector& p, std::optional<std::size_t>& place) {
  if (!place) place = unused_set();
  if (place)
    motions_.change_parameters(*place, p);
  else
    place = motions_.add_parameters(p);
}

/// Frees the slot for another task.
void TaskPool::clear(TaskSlot& place) {
  if (place.own_parameters_) free_parameters_.push_back(*place.own_parameters_);
  place.own_parameters_.reset();
  place.propagators_.clear();
  place.alone_ = false;
  place.urgent_ = false;
  place.requested_periods_ = 0;
  place.results_.clear();
}

/// The slot of the task with the most forcing periods, if these are more than `long_computation`; else null.
const TaskSlot* TaskPool::longest_task(std::span<const std::unique_ptr<Member>> members) {
  const TaskSlot* longest = nullptr;
  for (const auto& member : members) {
    const TaskSlot& place = member->place;
    if (place.requested_periods_ > (longest ? longest->requested_periods_ : long_computation)) longest = &place;
  }
  return longest;
}

/// Carries the tasks of one kind, which have `motions` unfinished runs in all. Tasks that others wait for go first.
void TaskPool::carry(std::span<const std::unique_ptr<Member>> members, bool tangent, std::size_t motions) {
  runs_.clear();
  for (const bool first : {true, false})
    for (const auto& member : members) {
      TaskSlot& place = member->place;
      if (place.tangent_ != tangent || hurries(place) != first) continue;
      for (TaskSlot::Run& run : place.runs_) {
        run.goes_first = &place == longest_;
        if (run.carried < run.periods) runs_.push_back(&run);
      }
    }
  tangent_ = tangent;
  share_ = std::clamp(work_of_turn / motions, fewest_periods, most_periods);
  left_ = work_of_turn;
  motions_.carry_while_full(runs_, tangent, share_, *this);
}

/// Feeds the lanes after a run has been carried for `periods` more periods, until the quota of the turn is used up.
void TaskPool::feed_lanes(TaskSlot::Run& run, std::size_t periods) {
  left_ -= std::min(left_, periods);
  if (run.carried < run.periods) {
    if (periods < share_ || run.goes_first) left_ = 0;  // the lanes are no longer full
    if (left_ > 0) motions_.join(run);
    return;
  }
  TaskSlot& place = *run.place;
  if (--place.open_ > 0 || left_ == 0) return;
  place.resume();
  if (place.open_ == 0 || place.tangent_ != tangent_) return;
  for (TaskSlot::Run& next : place.runs_) {
    next.goes_first = &place == longest_;
    motions_.join(next);
  }
}

void TaskPool::use_all_threads() {
  all_threads_ = true;
  motions_.use_all_threads();
}

/// Carries the remaining periods of these runs, at a parameter set.
void TaskPool::carry_rest(std::span<const TaskSlot::Run> runs, std::size_t set, bool tangent) {
  rest_.clear();
  for (const MotionRun& run : runs) {
    MotionStart now = run.now();
    now.parameters = set;
    rest_.push_back({now, run.periods - run.carried, run.results + run.carried, run.speeds});
  }
  motions_.carry(rest_, tangent);
}

/// Carries the runs of the pool's only task to their ends. False: idle pools would have to help, but none does.
bool TaskPool::carry_only(TaskSlot& place) {
  if (exchange_) return lend(place);
  carry_rest(place.runs_, place.parameters_, place.tangent_);
  place.open_ = 0;
  return true;
}

void TaskPool::run(std::size_t count, const std::function<MotionTask<>(std::size_t, TaskSlot&)>& make) {
  std::size_t begun = 0;
  run([&](TaskSlot& lane, std::size_t carried) -> std::optional<MotionTask<>> {
    if (begun < count) return make(begun++, lane);
    if (carried == 0 && exchange_) exchange_->close();
    return std::nullopt;
  });
}

void TaskPool::run(const std::function<std::optional<MotionTask<>>(TaskSlot&, std::size_t)>& next) {
  std::vector<std::unique_ptr<Member>> members, spare;
  const auto end = [&](std::unique_ptr<Member>& member) {
    member->task.result();
    member->task = {};
    clear(member->place);
    spare.push_back(std::move(member));
  };
  for (;;) {
    for (auto& member : members)
      if (member->task.ended()) end(member);
    std::erase(members, nullptr);
    if (exchange_ && members.size() > 1 && exchange_->wants()) give(members);
    while (members.size() < together) {
      if (spare.empty()) spare.push_back(std::make_unique<Member>(Member{TaskSlot(*this), {}}));
      auto task = next(spare.back()->place, members.size());
      if (!task) break;
      std::unique_ptr<Member> begun = std::move(spare.back());
      spare.pop_back();
      begun->task = std::move(*task);
      begun->task.begin();
      begun->task.ended() ? end(begun) : members.push_back(std::move(begun));
    }
    if (members.empty() && exchange_) take(members);
    if (members.empty()) {
      if (!exchange_ || exchange_->closed_) return;
      help();
      continue;
    }
    if (members.size() == 1 && carry_only(members.front()->place)) {
      members.front()->place.resume();
      continue;
    }
    std::array<std::size_t, 2> motions{};  // without and with the tangent
    std::array<bool, 2> hurry{};
    longest_ = longest_task(members);
    for (const auto& member : members) {
      const TaskSlot& place = member->place;
      motions[place.tangent_ ? 1 : 0] += place.open_;
      hurry[place.tangent_ ? 1 : 0] |= hurries(place);
    }
    // Small batches are postponed until more runs of the same kind are available.
    for (const std::size_t kind : {0, 1})
      if (hurry[kind] || motions[kind] >= std::min(busy, motions[1 - kind])) carry(members, kind == 1, motions[kind]);
    for (const auto& member : members)
      if (member->place.open_ == 0 && !member->task.ended()) member->place.resume();
  }
}

void run_tasks(const SharedSystem& system, const FlowOptions& options, bool all_threads, std::size_t count,
               const std::function<MotionTask<>(std::size_t, TaskSlot&)>& make) {
  const std::size_t parts = all_threads ? std::min(available_threads(), count) : 1;
  in_parallel(parts, [&](std::size_t part) {
    TaskPool pool(system, options);
    if (all_threads && count == 1) pool.use_all_threads();
    pool.run((count - part + parts - 1) / parts, [&](std::size_t i, TaskSlot& slot) { return make(part + i * parts, slot); });
  });
}

void run_alone(const SharedSystem& system, const FlowOptions& options, const std::function<MotionTask<>(TaskSlot&)>& make) {
  TaskPool pool(system, options);
  pool.alone_ = true;
  pool.run(1, [&](std::size_t, TaskSlot& slot) { return make(slot); });
}

}  // namespace graze
