// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/tasks/pool_member.hpp>
#include <graze/lib/tasks/work_sharing.hpp>

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

namespace graze {

namespace {

/// Number of runs that is worth a thread of its own.
constexpr std::size_t fewest_shared_runs = 8;

}  // namespace

/// A task on its way to another pool, with its parameter set.
struct WorkSharing::MovedTask {
  std::unique_ptr<TaskPool::Member> member;
  std::optional<LaneCarrier::Taken> parameters;
};

/// The remaining periods of a task's runs, divided into one part for each available thread.
struct TaskPool::SharedRuns {
  const TaskPool* by;
  std::size_t parameters;  ///< index in the pool `by`
  const Vector& p;
  std::shared_ptr<const ContactTable> table;
  bool tangent;
  const std::vector<TaskSlot::Run>& runs;
  std::size_t parts;
  // Guarded by WorkSharing:
  std::size_t taken = 0, through = 0;  ///< number of parts taken, and finished
  std::exception_ptr error = nullptr;
};
struct TaskPool::Part {
  SharedRuns* of = nullptr;
  std::size_t number = 0;
};

WorkSharing::WorkSharing(std::function<void()> wake) : wake_(std::move(wake)) {}
WorkSharing::~WorkSharing() = default;

void WorkSharing::put(std::vector<MovedTask> parcels) {
  {
    const std::lock_guard lock(mutex_);
    std::move(parcels.begin(), parcels.end(), std::back_inserter(parcels_));
    has_some_ = true;
  }
  wake_();
}

std::vector<WorkSharing::MovedTask> WorkSharing::get() {
  const std::lock_guard lock(mutex_);
  has_some_ = lent_ != nullptr;
  return std::exchange(parcels_, {});
}

bool WorkSharing::lend(SharedRuns& motions) {
  {
    const std::lock_guard lock(mutex_);
    if (lent_) return false;
    lent_ = &motions;
    has_some_ = true;
  }
  wake_();
  return true;
}

WorkSharing::Part WorkSharing::take_part(SharedRuns* of) {
  const std::lock_guard lock(mutex_);
  if (!of) of = lent_;
  if (!of || of->taken == of->parts) return {};
  const Part part{of, of->taken++};
  if (of == lent_ && of->taken == of->parts) lent_ = nullptr;
  has_some_ = lent_ || !parcels_.empty();
  return part;
}

void WorkSharing::give_back(const Part& part, std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  ++part.of->through;
  if (error) part.of->error = std::move(error);
  given_back_.notify_all();
}

void WorkSharing::wait_for_all(const SharedRuns& motions) {
  std::unique_lock lock(mutex_);
  given_back_.wait(lock, [&] { return motions.through == motions.parts; });
}

/// Moves every other task to an idle pool.
void TaskPool::give(std::vector<std::unique_ptr<Member>>& members) {
  std::vector<WorkSharing::MovedTask> parcels;
  for (std::size_t i = 1; i < members.size(); i += 2) {
    WorkSharing::MovedTask& parcel = parcels.emplace_back();
    parcel.member = std::move(members[i]);
    const std::optional<std::size_t>& own = parcel.member->place.own_parameters_;
    if (!own) continue;
    parcel.parameters = motions_.take(*own);
    free_parameters_.push_back(*own);
  }
  std::erase(members, nullptr);
  exchange_->put(std::move(parcels));
}

void TaskPool::take(std::vector<std::unique_ptr<Member>>& members) {
  for (WorkSharing::MovedTask& parcel : exchange_->get()) {
    TaskSlot& place = parcel.member->place;
    place.pool_ = this;
    if (parcel.parameters) {
      place.parameters_ = *(place.own_parameters_ = motions_.add(std::move(*parcel.parameters), unused_set()));
      for (TaskSlot::Run& run : place.runs_) run.start.parameters = place.parameters_;
    }
    members.push_back(std::move(parcel.member));
  }
}

/// Shares the runs of the pool's only task with idle pools until all are finished. False: not shared.
bool TaskPool::lend(TaskSlot& place) {
  const std::size_t parts = std::min(1 + exchange_->waiting(), place.open_ / fewest_shared_runs), set = place.parameters_;
  if (parts < 2 || motions_.awaits_table(set)) return false;
  SharedRuns lent{this, set, motions_.parameters(set), motions_.table(set), place.tangent_, place.runs_, parts};
  if (!exchange_->lend(lent)) return false;
  for (Part part; (part = exchange_->take_part(&lent)).of;) carry_part(part);
  exchange_->wait_for_all(lent);
  if (lent.error) std::rethrow_exception(lent.error);
  place.open_ = 0;
  return true;
}

/// Carries runs that another pool shares.
void TaskPool::help() {
  if (const Part part = exchange_->take_part(); part.of) carry_part(part);
}

void TaskPool::carry_part(const Part& part) {
  const auto& [of, number] = part;
  std::exception_ptr error;
  try {
    const std::size_t set = of->by == this ? of->parameters : set_for(*of), count = of->runs.size();
    const std::size_t begin = number * count / of->parts, end = (number + 1) * count / of->parts;
    carry_rest(std::span(of->runs).subspan(begin, end - begin), set, of->tangent);
  } catch (...) {
    error = std::current_exception();
  }
  exchange_->give_back(part, std::move(error));
}

/// The parameter set for runs of another pool.
std::size_t TaskPool::set_for(const SharedRuns& lent) {
  store_parameters(lent.p, shared_set_);
  if (lent.table) motions_.use(*shared_set_, lent.table);
  return *shared_set_;
}

}  // namespace graze
