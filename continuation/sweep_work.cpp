// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/sweep_work.hpp>
#include <graze/floquet/rounds.hpp>

#include <algorithm>
#include <span>
#include <utility>

namespace graze {

namespace {

/// So near a return, an orbit is looked for on the way; Newton's method decides.
constexpr double repeats = 1e-4;
/// Chaos that an average of so few forcing periods found has to be confirmed by a second one.
constexpr std::int64_t short_average = 500;
/// Forcing periods in which the tangent of a motion is turned, before its growth counts.
constexpr std::int64_t turning = 60;
/// So many motions fill the lanes of a thread.
constexpr std::size_t enough = 32;
/// What is begun so far behind a row that is open is likely to be in vain: behind so many whose orbits are known, or behind so
/// many others, for each thread some more.
constexpr std::size_t far_ahead = 64, far_in_chaos = 16, far_in_chaos_of_a_thread = 8;

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
      rows_of_a_thread_(std::max<std::size_t>(1, enough / static_cast<std::size_t>(options_.attractor.lyapunov.motions))) {
  for (const SweepDirection direction : options_.directions) {
    Way& way = ways_.emplace_back(Way{{system_, p, start, options_, direction}, {}});
    for (const SweepRow& row : so_far)
      if (row.direction == direction)
        way.entries.push_back(std::make_shared<Entry>(row, &way, SweepChain::Begin{way.entries.size(), {}}, true, true));
  }
  done_ = so_far.size();
}

bool SweepWork::goes_on(const Way& way) const { return !way.ended && way.entries.size() < way.chain.size() && !cancelled(); }

void SweepWork::work() try {
  {
    const std::lock_guard lock(mutex_);
    ++threads_;
  }
  ManyMotions many(system_, options_.attractor.lyapunov.flow);
  LanePool(many, &exchange_).run([&](LanePlace& lane, std::size_t carried) -> std::optional<LaneTask<>> {
    auto entry = draw(carried);
    if (!entry) return std::nullopt;
    return find(lane, std::move(entry));
  });
} catch (...) {
  const std::lock_guard lock(mutex_);
  failed_ = true;
  news_.notify_all();
  throw;
}

bool SweepWork::far_ahead_of_open(Way& way) const {
  const auto& entries = way.entries;
  while (way.first_open < entries.size() && entries[way.first_open]->done) ++way.first_open;
  if (way.open == 0) return false;
  const auto behind = std::span(entries).subspan(way.first_open);
  const auto is_open = [](const auto& entry) { return !entry->done; };
  const auto last_open = std::find_if(behind.rbegin(), behind.rend(), is_open);
  if (last_open - behind.rbegin() >= static_cast<std::ptrdiff_t>(far_ahead)) return true;
  const auto in_chaos = [](const auto& entry) { return entry->row.attractor.type != AttractorType::periodic; };
  const auto others = static_cast<std::size_t>(std::count_if(behind.begin(), behind.end(), in_chaos));
  return others > far_in_chaos + far_in_chaos_of_a_thread * threads_;
}

/// A direction whose next row can be begun, for a thread that carries so many: with some, if that is not likely to be in vain,
/// and others do not have fewer.
SweepWork::Way* SweepWork::next_way(std::size_t carried) {
  const auto fits = [&](Way& way) {
    if (way.looks_ahead || !goes_on(way)) return false;
    if (!way.entries.empty() && !way.entries.back()->handed_on) return false;
    return carried == 0 || (idle_ == 0 && carried * threads_ <= begun_ && !far_ahead_of_open(way));
  };
  const auto way = std::find_if(ways_.begin(), ways_.end(), fits);
  return way == ways_.end() ? nullptr : &*way;
}

/// What is begun next by a thread that carries so many rows. It waits if it has nothing to do.
std::shared_ptr<SweepWork::Entry> SweepWork::draw(std::size_t carried) {
  std::unique_lock lock(mutex_);
  for (;;) {
    if (carried >= rows_of_a_thread_) return nullptr;
    if (cancelled() || (carried == 0 && exchange_.has_some())) return nullptr;
    const bool unfinished =
        std::any_of(ways_.begin(), ways_.end(), [&](const Way& way) { return way.open > 0 || way.looks_ahead || goes_on(way); });
    if (!unfinished) return nullptr;
    if (Way* const way = next_way(carried)) {
      if (auto entry = next_row(*way, lock)) return entry;
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

/// For the orbits of the next rows. False: rows were taken back meanwhile.
bool SweepWork::look_ahead(Way& way, std::unique_lock<std::mutex>& lock) {
  const auto& entries = way.entries;
  const std::size_t number = entries.size(), block = SweepChain::block_of(number), taken_back = way.taken_back;
  std::vector<std::vector<Vector>> before;
  for (std::size_t k = block; k > 0 && before.size() < most_orbits_before; --k) {
    const Entry& entry = *entries[k - 1];
    if (!entry.done || !SweepChain::alike(entry.row, entries[k == block ? k - 1 : k]->row)) break;
    before.insert(before.begin(), entry.row.states);
  }
  way.looks_ahead = true;
  lock.unlock();
  try {
    way.chain.look_ahead(number, before);
  } catch (...) {
    lock.lock();
    way.looks_ahead = false;
    throw;
  }
  lock.lock();
  way.looks_ahead = false;
  news_.notify_all();
  if (way.taken_back == taken_back) return true;
  way.chain.forget();
  return false;
}

/// The next row, to be found; null: it is known already.
std::shared_ptr<SweepWork::Entry> SweepWork::next_row(Way& way, std::unique_lock<std::mutex>& lock) {
  const auto& entries = way.entries;
  const std::size_t number = entries.size();
  std::optional<SweepRow> known;
  if (number == 0 || entries.back()->done) {
    if (way.chain.looks_ahead(number) && !look_ahead(way, lock)) return nullptr;
    known = way.chain.ahead(number);
  }
  const bool done = known.has_value();
  SweepChain::Begin begin{number, way.chain.start(), true};
  if (number > 0) {
    begin.state = entries.back()->row.end;
    begin.settled = entries.back()->row.attractor.type == AttractorType::periodic;
  }
  auto entry = std::make_shared<Entry>(done ? std::move(*known) : way.chain.row(number), &way, std::move(begin), done, done);
  way.entries.push_back(entry);
  if (done) {
    ++done_;
    tell(entry->row.value);
    news_.notify_all();
    return nullptr;
  }
  ++way.open;
  ++begun_;
  return entry;
}

LaneTask<> SweepWork::find(LanePlace& lane, std::shared_ptr<Entry> entry) {
  const SweepChain& chain = entry->way->chain;
  AttractorOptions finding = options_.attractor;
  finding.lyapunov.cancelled = [this, &entry] { return entry->dropped || cancelled(); };
  SweepRow row = entry->row;
  try {
    row = co_await chain.find(lane, entry->begin, finding, [this, &entry](const Vector& state) { hand_on(*entry, state); });
  } catch (const std::invalid_argument&) {  // it would begin inside the barrier
  }
  finish(*entry, std::move(row));
}

/// Of a row that was begun: the next one may be.
void SweepWork::hand_on(Entry& entry, const Vector& state) {
  const std::lock_guard lock(mutex_);
  if (entry.dropped || cancelled()) return;
  entry.row.end = state;
  entry.handed_on = true;
  news_.notify_all();
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
    take_back(way, broken ? entry.begin.number : entry.begin.number + 1);
    way.ended = broken;
  }
  if (broken) return;
  entry.row = std::move(row);
  entry.handed_on = entry.done = true;
  --way.open;
  ++done_;
  tell(entry.row.value);
}

/// Rows from this one on.
void SweepWork::take_back(Way& way, std::size_t from) {
  if (from >= way.entries.size()) return;
  ++way.taken_back;
  if (!way.looks_ahead) way.chain.forget();
  for (std::size_t k = from; k < way.entries.size(); ++k) {
    Entry& entry = *way.entries[k];
    entry.dropped = true;
    entry.done ? --done_ : --way.open;
  }
  way.entries.resize(from);
  way.first_open = std::min(way.first_open, from);
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
