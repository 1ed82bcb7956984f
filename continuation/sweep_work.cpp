// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/sweep_work.hpp>
#include <graze/floquet/attractor_in_lanes.hpp>
#include <graze/floquet/rounds.hpp>

#include <algorithm>
#include <utility>

namespace graze {

namespace {

/// So near a return, an orbit is looked for on the way; Newton's method decides.
constexpr double repeats = 1e-4;
/// Chaos that an average of so few forcing periods found has to be confirmed by a second one.
constexpr std::int64_t short_average = 500;
/// Forcing periods in which the tangent of a motion is turned, before its growth counts.
constexpr std::int64_t turning = 60;
/// So many motions fill the lanes of a thread. What it would begin beyond them may be in vain.
constexpr std::size_t enough = 32;
/// The fewest that are begun where much has been in vain.
constexpr std::size_t fewest = 8;
/// And so may be rows behind the last that is open.
constexpr std::size_t far_ahead = 64;

SweepOptions with_looks(SweepOptions options) {
  options.attractor.recurrence = repeats;
  options.attractor.confirmed_below = short_average;
  LyapunovOptions& averaging = options.attractor.lyapunov;
  averaging.aligning = std::max(averaging.aligning, turning);
  averaging.motions = std::max(averaging.motions, motions_in_company(averaging));
  return options;
}

/// Whether an average was broken off.
bool broken_off(LyapunovStop stop) {
  return stop == LyapunovStop::interrupted || stop == LyapunovStop::failed || stop == LyapunovStop::not_run;
}

}  // namespace

SweepWork::SweepWork(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
                     const std::vector<SweepRow>& so_far)
    : system_(system), options_(with_looks(options)),
      enough_(std::max<std::size_t>(1, enough / static_cast<std::size_t>(options_.attractor.lyapunov.motions))),
      rows_of_a_thread_(enough_) {
  for (const SweepDirection direction : options_.directions) {
    Way& way = ways_.emplace_back(Way{{system_, p, start, options_, direction}, {}, {}});
    for (const SweepRow& row : so_far)
      if (row.direction == direction) way.entries.push_back(std::make_shared<Entry>(row, &way, way.entries.size(), 0, true));
  }
  done_ = so_far.size();
}

bool SweepWork::goes_on(const Way& way) const { return !way.ended && way.entries.size() < way.chain.size() && !cancelled(); }

void SweepWork::work() try {
  ManyMotions many(system_, options_.attractor.lyapunov.flow);
  LanePool(many, &exchange_).run([&](LanePlace& lane, std::size_t carried) -> std::optional<LaneTask<>> {
    auto entry = draw(carried);
    if (!entry) return std::nullopt;
    return settle(lane, std::move(entry));
  });
} catch (...) {
  const std::lock_guard lock(mutex_);
  failed_ = true;
  news_.notify_all();
  throw;
}

/// The first row that waits, of all directions.
std::shared_ptr<SweepWork::Entry> SweepWork::next_waiting() {
  for (Way& way : ways_) {
    if (way.waiting.empty()) continue;
    std::shared_ptr<Entry> entry = std::move(way.waiting.front());
    way.waiting.pop_front();
    ++begun_;
    return entry;
  }
  return nullptr;
}

bool SweepWork::far_ahead_of_open(const Way& way) const {
  const std::size_t rows = way.entries.size();
  if (way.open == 0 || rows < far_ahead) return false;
  return std::all_of(way.entries.end() - far_ahead, way.entries.end(), [](const auto& entry) { return entry->done; });
}

/// A direction that no thread follows, for one that carries so many rows: with some, if that is not likely to be in vain, and no
/// other thread has nothing to do.
SweepWork::Way* SweepWork::to_follow(std::size_t carried) {
  const auto fits = [&](const Way& way) {
    return !way.followed && goes_on(way) && (carried == 0 || (idle_ == 0 && !far_ahead_of_open(way)));
  };
  const auto way = std::find_if(ways_.begin(), ways_.end(), fits);
  return way == ways_.end() ? nullptr : &*way;
}

/// What is begun next by a thread that carries so many rows. If none waits it follows a motion; it waits if it has nothing to do.
std::shared_ptr<SweepWork::Entry> SweepWork::draw(std::size_t carried) {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (carried >= rows_of_a_thread_) return nullptr;
    if (cancelled() || (carried == 0 && exchange_.has_some())) return nullptr;
    std::size_t waiting = 0;
    bool unfinished = false;
    for (const Way& way : ways_) {
      waiting += way.waiting.size();
      unfinished = unfinished || way.open > 0 || way.followed || goes_on(way);
    }
    if (!unfinished) return nullptr;
    Way* const way = to_follow(carried);
    // Where others have rows, who has none goes ahead for them.
    const bool leads = carried == 0 && begun_ > 0 && waiting < rows_of_a_thread_;
    if (waiting > 0 && !(way && leads)) return next_waiting();
    if (way) {
      follow(*way, lock);
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

SweepChain::Before SweepWork::before_next(const Way& way) const {
  const auto& entries = way.entries;
  const std::size_t number = entries.size(), block = SweepChain::block_of(number);
  SweepChain::Before before{number, way.chain.start(), true, {}};
  if (number > 0) {
    before.end = entries.back()->row.end;
    before.settled = entries.back()->row.attractor.type == AttractorType::periodic;
  }
  for (std::size_t k = block; k > 0 && before.orbits.size() < most_orbits_before; --k) {
    const Entry& entry = *entries[k - 1];
    const bool fits =
        entry.done && (k == block ? SweepChain::alike(entry.row, entry.row) : SweepChain::alike(entry.row, entries[k]->row));
    if (!fits) break;
    before.orbits.insert(before.orbits.begin(), entry.row.states);
  }
  return before;
}

/// The next row.
void SweepWork::follow(Way& way, std::unique_lock<std::mutex>& lock) {
  way.followed = true;
  const std::size_t taken_back = way.taken_back;
  const SweepChain::Before before = before_next(way);
  lock.unlock();
  std::optional<SweepRow> row;
  try {
    row = way.chain.row(before);
  } catch (...) {
    lock.lock();
    way.followed = false;
    throw;
  }
  lock.lock();
  way.followed = false;
  if (way.taken_back != taken_back) {
    way.chain.forget();
  } else if (!row) {
    way.ended = true;
  } else {
    const bool done = row->attractor.type == AttractorType::periodic;
    const auto entry = std::make_shared<Entry>(std::move(*row), &way, before.number, way.chain.transient_left(before), done);
    way.entries.push_back(entry);
    if (done) {
      ++done_;
      tell(entry->row.value);
    } else {
      ++way.open;
      way.waiting.push_back(entry);
    }
  }
  news_.notify_all();
}

/// What a row that was left behind is.
LaneTask<> SweepWork::settle(LanePlace& lane, std::shared_ptr<Entry> entry) {
  AttractorOptions finding = options_.attractor;
  finding.lyapunov.cancelled = [this, &entry] { return entry->dropped || cancelled(); };
  finding.transient = entry->transient_left;
  const SweepChain& chain = entry->way->chain;
  SweepRow row = entry->row;
  const Vector p = chain.parameters(row.value), from = row.end;
  row.attractor = co_await find_attractor_in_lanes(lane, system_, p, from, finding);
  if (row.attractor.type == AttractorType::periodic) {
    chain.sample_orbit(row);
    row.end = row.attractor.state;
  } else if (!finding.lyapunov.cancelled()) {
    co_await sample(lane, chain, row);
  }
  finish(*entry, std::move(row));
}

/// Of a motion that is not periodic.
LaneTask<> SweepWork::sample(LanePlace& lane, const SweepChain& chain, SweepRow& row) const {
  if (options_.samples < 1) co_return;
  if (!ManyMotions::applies(system_, chain.parameters(row.value), options_.attractor.lyapunov.flow)) {
    chain.sample_motion(row);
    co_return;
  }
  lane.take_parameters(chain.parameters(row.value));
  ImpactSpeeds speeds;
  const Vector from = row.attractor.state;
  const std::span<const PeriodResult> periods = co_await lane.carry(from, static_cast<std::size_t>(options_.samples), &speeds);
  row.states = {from};
  for (const PeriodResult& period : periods.first(periods.size() - 1))
    if (period.termination == Termination::time) row.states.push_back(Vector{{period.x, period.v}});
  row.impact_speeds = speeds.list();
}

void SweepWork::finish(Entry& entry, SweepRow row) {
  const std::lock_guard lock(mutex_);
  --begun_;
  news_.notify_all();
  if (entry.dropped) return;
  Way& way = *entry.way;
  const bool periodic = row.attractor.type == AttractorType::periodic;
  // (What cut it short need not have left a trace.)
  const bool broken = !periodic && (broken_off(row.attractor.time_average.stop) || cancelled());
  if (broken || periodic) {
    take_back(way, broken ? entry.number : entry.number + 1);
    way.ended = broken;
  }
  if (broken) return;
  rows_of_a_thread_ = std::min(rows_of_a_thread_ + 1, enough_);
  entry.row = std::move(row);
  entry.done = true;
  --way.open;
  ++done_;
  tell(entry.row.value);
}

/// Rows from this one on.
void SweepWork::take_back(Way& way, std::size_t from) {
  ++way.taken_back;
  rows_of_a_thread_ = std::max(rows_of_a_thread_ / 2, std::min(enough_, fewest));
  if (!way.followed) way.chain.forget();
  for (std::size_t k = from; k < way.entries.size(); ++k) {
    Entry& entry = *way.entries[k];
    entry.dropped = true;
    entry.done ? --done_ : --way.open;
  }
  way.entries.resize(from);
  std::erase_if(way.waiting, [](const auto& entry) { return entry->dropped.load(); });
}

void SweepWork::tell(double value) {
  if (options_.progress) options_.progress(done_, value);
}

std::vector<SweepRow> SweepWork::rows() && {
  std::vector<SweepRow> all;
  for (Way& way : ways_)
    for (const auto& entry : way.entries) {
      if (!entry->done) break;
      all.push_back(std::move(entry->row));
    }
  return all;
}

}  // namespace graze
