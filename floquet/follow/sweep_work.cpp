// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor_decision.hpp>
#include <graze/floquet/follow/sweep_work.hpp>

#include <algorithm>
#include <iterator>
#include <utility>

namespace graze {

namespace {

/// Returns this close trigger a search for an orbit; Newton's method decides.
constexpr double repeats = 1e-4;
/// Chaos found by an average over fewer forcing periods must be confirmed by a second one.
constexpr std::int64_t short_average = 500;
/// Forcing periods that align the tangent of a motion before its growth counts.
constexpr std::int64_t aligning_periods = 60;
/// Number of motions that fills the lanes of a thread. A thread with less than half a batch also starts speculative rows.
constexpr std::size_t enough = 32;
/// Stretches of a direction that may run after an unconfirmed guess, in addition to one per thread.
constexpr std::size_t guesses = 8;

SweepOptions with_looks(SweepOptions options) {
  options.attractor.recurrence = repeats;
  options.attractor.confirmed_below = short_average;
  LyapunovOptions& averaging = options.attractor.lyapunov;
  averaging.aligning = std::max(averaging.aligning, aligning_periods);
  averaging.motions = std::max(averaging.motions, motions_in_shared_lanes(averaging));
  return options;
}

void append(std::vector<SweepRow> rows, std::vector<SweepRow>& all) {
  if (all.empty()) return all.swap(rows);
  all.insert(all.end(), std::make_move_iterator(rows.begin()), std::make_move_iterator(rows.end()));
}

/// Whether an average is incomplete.
bool broken_off(LyapunovStop stop) {
  return stop == LyapunovStop::interrupted || stop == LyapunovStop::failed || stop == LyapunovStop::not_run;
}

}  // namespace

SweepWork::SweepWork(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
                     const std::vector<SweepRow>& so_far)
    : system_(system), options_(with_looks(options)),
      rows_of_a_thread_(std::max<std::size_t>(1, enough / static_cast<std::size_t>(options_.attractor.lyapunov.motions))) {
  for (const SweepDirection direction : options_.directions)
    directions_.emplace_back(SweepChain(system_, p, start, options_, direction), so_far);
}

void SweepWork::work() try {
  {
    const std::lock_guard lock(mutex_);
    ++threads_;
  }
  LaneCarrier many(system_, options_.attractor.lyapunov.flow);
  TaskPool(many, &exchange_).run([&](TaskSlot& lane, std::size_t carried) -> std::optional<MotionTask<>> {
    auto entry = draw(carried);
    if (!entry) return std::nullopt;
    return find(lane, std::move(entry));
  });
} catch (...) {
  const std::lock_guard lock(mutex_);
  failed_ = true;
  tell_news();
  throw;
}

/// The next row for a thread with `carried` rows. Waits if the thread has nothing to do.
std::shared_ptr<SweepWork::Entry> SweepWork::draw(std::size_t carried) {
  Lock lock(mutex_);
  for (;;) {
    if (carried >= rows_of_a_thread_) return nullptr;
    const auto is_finished = [](const SweepStretches& direction) { return direction.finished(); };
    if (cancelled() || std::all_of(directions_.begin(), directions_.end(), is_finished)) {
      exchange_.close();
      return nullptr;
    }
    if (carried == 0 && exchange_.has_some()) return nullptr;
    if (carried > 0 && (idle_ > 0 || carried * threads_ > begun_)) return nullptr;  // others have fewer
    if (const auto begun = go_on(carried, lock)) {
      if (*begun) return *begun;
      continue;
    }
    if (carried > 0) return nullptr;
    ++idle_;
    exchange_.begin_waiting();
    news_.wait(lock);
    exchange_.end_waiting();
    --idle_;
  }
}

/// A started row; null: a predicted row was added, so try again; nullopt: nothing can be started.
std::optional<std::shared_ptr<SweepWork::Entry>> SweepWork::go_on(std::size_t carried, Lock& lock) {
  for (SweepStretches& direction : directions_)
    if (const auto stretch = direction.next(2 * carried < rows_of_a_thread_)) return next_row(direction, *stretch, lock);
  for (SweepStretches& direction : directions_)
    if (auto guess = direction.guess(guesses + threads_)) {
      ++begun_;
      return guess;
    }
  return std::nullopt;
}

/// Predicts the orbits of the next block without holding the lock. False: rows were rolled back meanwhile.
bool SweepWork::look_ahead(SweepStretches& direction, Stretch& stretch, Lock& lock) {
  const std::size_t number = stretch.next(), rollbacks = stretch.rollbacks;
  const std::vector<std::vector<Vector>> before = direction.orbits_before(stretch);
  stretch.looks_ahead = true;
  lock.unlock();
  SweepChain::Block ahead = direction.chain().look_ahead(number, before);  // if this throws, work() ends all
  lock.lock();
  stretch.looks_ahead = false;
  tell_news();
  if (stretch.rollbacks != rollbacks) return false;
  stretch.ahead = std::move(ahead);
  return true;
}

/// The next row, to be computed; null: it is known from a prediction, or rows were rolled back.
std::shared_ptr<SweepWork::Entry> SweepWork::next_row(SweepStretches& direction, Stretch& stretch, Lock& lock) {
  const std::size_t number = stretch.next();
  std::optional<SweepRow> known;
  if (!stretch.last() || stretch.last()->done) {
    if (direction.chain().looks_ahead(stretch.ahead, number) && !look_ahead(direction, stretch, lock)) return nullptr;
    known = direction.chain().known(stretch.ahead, number);
  }
  auto entry = direction.add(stretch, std::move(known));
  if (entry->done) {
    tell(direction.chain().value(number));
    tell_news();
    return nullptr;
  }
  ++begun_;
  return entry;
}

MotionTask<> SweepWork::find(TaskSlot& lane, std::shared_ptr<Entry> entry) {
  AttractorOptions finding = options_.attractor;
  finding.lyapunov.cancelled = [this, &entry] { return entry->dropped || cancelled(); };
  SweepRow row = entry->direction->chain().row(entry->begin.number);
  try {
    row = co_await entry->direction->chain().find(lane, entry->begin, finding,
                                                  [this, &entry](const Vector& state) { publish(*entry, state); });
  } catch (const std::invalid_argument&) {  // the start lies inside the barrier
  }
  finish(*entry, std::move(row));
}

/// Wakes waiting threads: there may be something to do.
void SweepWork::tell_news() {
  if (idle_ > 0) news_.notify_all();
}

/// Publishes the state of a started row: the next one can start.
void SweepWork::publish(Entry& entry, const Vector& state) {
  const std::lock_guard lock(mutex_);
  if (cancelled()) return;
  entry.direction->publish(entry, state);
  tell_news();
}

void SweepWork::finish(Entry& entry, SweepRow row) {
  const std::lock_guard lock(mutex_);
  --begun_;
  tell_news();
  // A cancelled row need not show it.
  const Attractor& attractor = row.attractor;
  const bool rests = attractor.termination == Termination::no_return;  // also a valid result
  const bool broken =
      attractor.type != AttractorType::periodic && !rests && (broken_off(attractor.time_average.stop) || cancelled());
  const double value = row.value;
  entry.direction->finish(entry, std::move(row), broken);
  if (!broken) tell(value);
}

void SweepWork::tell(double value) {
  std::size_t done = 0;
  for (const SweepStretches& direction : directions_) done += direction.done();
  if (options_.progress) options_.progress(done, value);
  const auto rows = [this] {
    std::vector<SweepRow> all;
    for (const SweepStretches& direction : directions_) append(direction.so_far(), all);
    return all;
  };
  if (options_.keep) options_.keep(rows);
}

std::vector<SweepRow> SweepWork::rows() && {
  std::vector<SweepRow> all;
  for (SweepStretches& direction : directions_) append(std::move(direction).so_far(), all);
  return all;
}

}  // namespace graze
