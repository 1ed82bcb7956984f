// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/follow/row_runner.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <algorithm>
#include <utility>

namespace graze {

RowRunner::RowRunner(const SharedSystem& system, RowRunnerOptions options) : system_(system), options_(std::move(options)) {}

void RowRunner::give(const std::vector<std::shared_ptr<Row>>& rows) {
  const std::lock_guard lock(mutex_);
  for (const auto& row : rows) {
    row->queued = row->next();
    if (row->queued != Row::Next::none) queue_of(row->queued).push_back(row);
  }
  news_.notify_all();
}

void RowRunner::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  news_.notify_all();
}

std::size_t RowRunner::ready() const {
  const std::lock_guard lock(mutex_);
  return likely_.size();
}

void RowRunner::work() try {
  TaskPool(system_, options_.flow, &exchange_).run([&](TaskSlot& slot, std::size_t carried) -> std::optional<MotionTask<>> {
    std::optional<Started> started = draw(carried);
    if (!started) return std::nullopt;
    return find(slot, std::move(*started));
  });
} catch (...) {
  const std::lock_guard lock(mutex_);
  failed_ = true;
  news_.notify_all();
  throw;
}

/// Number of points that a thread may carry, so that the others get as many.
std::size_t RowRunner::share() const {
  const std::size_t threads = options_.threads;
  const std::size_t share = divide_rounding_up(likely_.size() + unlikely_.size() + guesses_.size() + open_, threads);
  const std::size_t most = threads == 1 ? share : std::max(options_.enough, divide_rounding_up(likely_.size(), threads));
  return std::min({share, most, options_.most});
}

/// The next point for a thread with `carried` points. Waits if the thread has nothing to do.
std::optional<RowRunner::Started> RowRunner::draw(std::size_t carried) {
  Lock lock(mutex_);
  if (carried == 0 && !has_some() && !exchange_.has_some()) {
    exchange_.begin_waiting();
    news_.wait(lock, [this] { return over() || has_some() || exchange_.has_some(); });
    exchange_.end_waiting();
  }
  if (over()) exchange_.close();
  if (carried == 0 && exchange_.has_some()) return std::nullopt;
  while (!failed_ && carried < share()) {
    const std::shared_ptr<Row> row = next(2 * carried < options_.enough);
    if (!row) break;
    std::optional<Started> started = start(row, lock);
    tell(lock);
    if (started) return started;
  }
  return std::nullopt;
}

/// Tells the listeners of finished rows, without holding the lock; wakes the waiting threads if all is done.
void RowRunner::tell(Lock& lock) {
  for (; !untold_.empty(); lock.lock()) {
    const std::shared_ptr<Row> row = std::move(untold_.front());
    untold_.pop_front();
    lock.unlock();
    if (row->listener().finished) row->listener().finished();
  }
  if (over()) news_.notify_all();
}

RowRunner::Queue& RowRunner::queue_of(Row::Next next) {
  return next == Row::Next::likely ? likely_ : next == Row::Next::unlikely ? unlikely_ : guesses_;
}

/// Takes the next row to continue; with `speculative`, also one whose point will probably be rolled back.
std::shared_ptr<Row> RowRunner::next(bool speculative) {
  Queue* const queue = !likely_.empty()                    ? &likely_
                       : speculative && !unlikely_.empty() ? &unlikely_
                       : !guesses_.empty()                 ? &guesses_
                                                           : nullptr;
  if (!queue) return nullptr;
  std::shared_ptr<Row> first = std::move(queue->front());
  queue->pop_front();
  first->queued = Row::Next::none;
  return first;
}

/// Moves a row to the queue that matches its present state.
void RowRunner::queue(const std::shared_ptr<Row>& row) {
  const Row::Next next = row->next();
  if (next == row->queued) return;
  if (row->queued != Row::Next::none) std::erase(queue_of(row->queued), row);
  row->queued = next;
  if (next == Row::Next::none) return;
  next == Row::Next::likely ? likely_.push_front(row) : queue_of(next).push_back(row);
  news_.notify_all();
}

/// Starts the next point of a row. None: points were added whose orbits were predicted, or points were rolled back meanwhile.
std::optional<RowRunner::Started> RowRunner::start(const std::shared_ptr<Row>& row, Lock& lock) {
  Started started{row, nullptr};
  if (const auto stretch = row->stretch_to_continue()) {
    if (row->needs_prediction(*stretch) && !predict(row, *stretch, lock)) {
      queue(row);
      return std::nullopt;
    }
    started.entry = row->start(*stretch);
    if (started.entry->done) {
      if (row->finished()) untold_.push_back(row);
      if (row->listener().done) row->listener().done(started.entry->begin.number);
      queue(row);
      return std::nullopt;
    }
  } else {
    if (row->next() != Row::Next::guess) return std::nullopt;
    started.entry = row->start_guess();
  }
  ++open_;
  queue(row);
  return started;
}

/// Predicts the orbits of the next block without holding the lock. False: points were rolled back meanwhile.
bool RowRunner::predict(const std::shared_ptr<Row>& row, Row::Stretch& stretch, Lock& lock) {
  const std::size_t begin = Row::block_of(stretch.next()), rollbacks = stretch.rollbacks;
  const std::vector<std::vector<Vector>> before = row->orbits_before(stretch);
  stretch.predicting = true;
  ++open_;
  queue(row);  // other stretches can go on
  lock.unlock();
  std::vector<PredictedOrbit> orbits = row->chain().predict(begin, row->end_of_block(begin), before);  // a throw ends all
  lock.lock();
  --open_;
  stretch.predicting = false;
  if (stretch.rollbacks != rollbacks) return false;
  stretch.predicted_block = begin;
  stretch.predicted_orbits = std::move(orbits);
  return true;
}

MotionTask<> RowRunner::find(TaskSlot& slot, Started started) {
  for (std::optional<Started> next = std::move(started); next;) {
    const Started& now = *next;
    const std::function<bool()> cancelled = [this, &now] { return now.entry->dropped || this->cancelled(); };
    const std::function<void(const Vector&)> publish = [this, &now](const Vector& state) {
      const std::lock_guard lock(mutex_);
      now.row->publish(*now.entry, state);
      queue(now.row);
    };
    RowChain::Found found = co_await now.row->chain().find(slot, now.entry->begin, cancelled, publish);
    next = finish(now, std::move(found));
  }
}

/// Stores the result of a point. Returns the next point of its row, started, if no other thread is to start it.
std::optional<RowRunner::Started> RowRunner::finish(const Started& started, RowChain::Found found) {
  const std::shared_ptr<Row> row = started.row;
  const bool keeps = !found.failed && !started.entry->dropped;
  std::optional<Started> next;
  Lock lock(mutex_);
  const bool finished = row->finished();
  row->finish(*started.entry, std::move(found));
  --open_;
  if (!finished && row->finished()) untold_.push_back(row);
  if (keeps && row->listener().done) row->listener().done(started.entry->begin.number);
  while (!failed_ && !next && row->queued == Row::Next::none && row->next() == Row::Next::likely) next = start(row, lock);
  if (!next) queue(row);
  tell(lock);
  return next;
}

}  // namespace graze
