// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/follow/same_attractor.hpp>
#include <graze/floquet/follow/sweep_stretches.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace graze {

namespace {

/// About the number of stretches, rounded to whole blocks.
std::size_t length_of_stretches(std::size_t rows) {
  return SweepChain::block_of(static_cast<std::size_t>(std::sqrt(rows)) + SweepChain::block);
}

}  // namespace

SweepStretches::SweepStretches(SweepChain chain, const std::vector<SweepRow>& so_far)
    : chain_(std::move(chain)), length_(length_of_stretches(chain_.size())) {
  rows_.reserve(chain_.size());
  const auto is_own = [this](const SweepRow& row) { return row.direction == chain_.direction(); };
  std::copy_if(so_far.begin(), so_far.end(), std::back_inserter(rows_), is_own);
  done_ = kept_ = rows_.size();
  if (finished()) return;
  // The stretch in progress. With no row after it, its last row has not been compared with a guess yet.
  kept_ = kept_ == 0 ? 0 : (kept_ - 1) / length_ * length_;
  Stretch& stretch = add_stretch(kept_);
  for (std::size_t k = kept_; k < done_; ++k)
    stretch.entries.push_back(
        std::make_shared<Entry>(this, &stretch, SweepChain::Begin{.number = k, .state = {}}, &rows_[k], true, true));
}

SweepStretches::Stretch& SweepStretches::add_stretch(std::size_t begin) {
  const std::size_t end = std::min(begin + length_, chain_.size());
  rows_.resize(end);
  return *stretches_.emplace_back(std::make_shared<Stretch>(begin, end));
}

bool SweepStretches::can_go_on(const Stretch& stretch) const {
  if (stretch.looks_ahead || stretch.ended || stretch.next() == stretch.end) return false;
  return stretch.next() == 0 || (stretch.last() && stretch.last()->published);
}

std::shared_ptr<SweepStretches::Stretch> SweepStretches::next(bool speculative) {
  const auto fits = [&](const auto& stretch) {
    const bool is_guess = !stretch->joined && stretch != stretches_.front();
    return can_go_on(*stretch) && (!is_guess || last_guess_accepted_ || speculative);
  };
  const auto one = std::find_if(stretches_.begin(), stretches_.end(), fits);
  return one == stretches_.end() ? nullptr : *one;
}

std::shared_ptr<SweepStretches::Entry> SweepStretches::guess(std::size_t most) {
  if (stretches_.empty() || stretches_.back()->end == chain_.size()) return nullptr;
  const std::size_t begin = stretches_.back()->end;
  const auto is_open = [](const auto& stretch) { return stretch->begin > 0 && !stretch->joined; };
  if (static_cast<std::size_t>(std::count_if(stretches_.begin(), stretches_.end(), is_open)) >= most) return nullptr;
  Stretch& stretch = add_stretch(begin);
  const SweepChain::Begin from{.number = begin - 1, .state = chain_.start(), .at_start = true};
  stretch.guessed = chain_.row(begin - 1);
  return stretch.lead = stretch.guess = std::make_shared<Entry>(this, &stretch, from, &stretch.guessed);
}

std::vector<std::vector<Vector>> SweepStretches::orbits_before(const Stretch& stretch) const {
  const auto& entries = stretch.entries;
  const std::size_t block = SweepChain::block_of(stretch.next());
  std::vector<std::vector<Vector>> before;
  for (std::size_t k = block - stretch.begin; k > 0 && before.size() < most_orbits_before; --k) {
    const SweepRow &row = *entries[k - 1]->row, &next = before.empty() ? row : *entries[k]->row;
    if (!entries[k - 1]->done || !SweepChain::alike(row, next)) break;
    before.insert(before.begin(), row.states);
  }
  return before;
}

std::shared_ptr<SweepStretches::Entry> SweepStretches::add(Stretch& stretch, std::optional<SweepRow> known) {
  const std::size_t number = stretch.next();
  const bool done = known.has_value();
  SweepChain::Begin begin{.number = number, .state = chain_.start(), .at_start = true};
  if (const Entry* const last = stretch.last())
    begin = {.number = number, .state = last->row->end, .settled = last->row->attractor.type == AttractorType::periodic};
  rows_[number] = done ? std::move(*known) : chain_.row(number);
  auto entry = std::make_shared<Entry>(this, &stretch, std::move(begin), &rows_[number], done, done);
  stretch.entries.push_back(entry);
  done ? ++done_ : ++stretch.open;
  if (done) join();
  return entry;
}

void SweepStretches::publish(Entry& entry, const Vector& state) {
  if (entry.dropped) return;
  entry.row->end = state;
  entry.published = true;
}

void SweepStretches::finish(Entry& entry, SweepRow row, bool broken) {
  if (entry.dropped) return;
  Stretch& stretch = *entry.stretch;
  const bool is_guess = stretch.guess.get() == &entry;
  const std::size_t behind = is_guess ? 0 : entry.begin.number + 1 - stretch.begin;
  if (broken) {
    roll_back(stretch, is_guess ? behind : behind - 1);
    if (is_guess)
      stretch.guess = stretch.lead = nullptr;
    else
      stretch.ended = true;
  } else {
    if (row.attractor.type == AttractorType::periodic) roll_back(stretch, behind);
    *entry.row = std::move(row);
    entry.published = entry.done = true;
    if (!is_guess) {
      --stretch.open;
      ++done_;
    }
  }
  join();
}

/// Rolls back the rows of a stretch from this one on, counted from its first.
void SweepStretches::roll_back(Stretch& stretch, std::size_t from) {
  if (stretch.done())  // its last row will change
    for (const auto& next : stretches_)
      if (next->begin == stretch.end) next->joined = false;
  stretch.ended = false;
  if (from >= stretch.entries.size()) return;
  ++stretch.rollbacks;
  stretch.ahead = {};
  for (std::size_t k = from; k < stretch.entries.size(); ++k) {
    Entry& entry = *stretch.entries[k];
    entry.dropped = true;
    entry.done ? --done_ : --stretch.open;
  }
  stretch.entries.resize(from);
}

/// Links a stretch to the end of the one before. It keeps its guess if that is on the attractor of the last row there;
/// otherwise it starts again after that row.
void SweepStretches::follow(const SweepRow& last, Stretch& behind) {
  behind.joined = true;
  last_guess_accepted_ = behind.guess && on_same_attractor(last, *behind.guess->row);
  if (last_guess_accepted_ && behind.lead == behind.guess) return;
  roll_back(behind, 0);
  const auto anew = [&] {
    behind.known = last;
    return std::make_shared<Entry>(this, &behind, SweepChain::Begin{.number = behind.begin - 1, .state = {}}, &behind.known, true,
                                   true);
  };
  behind.lead = last_guess_accepted_ ? behind.guess : anew();
}

void SweepStretches::join() {
  for (std::size_t i = 0; i + 1 < stretches_.size(); ++i) {
    Stretch& behind = *stretches_[i + 1];
    if (stretches_[i]->done() && !behind.joined && (!behind.guess || behind.guess->done))
      follow(*stretches_[i]->entries.back()->row, behind);
  }
  const auto nothing_can_change = [&] {
    return stretches_.front()->done() &&
           (stretches_.size() > 1 ? stretches_[1]->joined : stretches_.front()->end == chain_.size());
  };
  while (!stretches_.empty() && nothing_can_change()) keep_first();
  if (stretches_.empty() || !stretches_.front()->ended || stretches_.front()->open > 0) return;
  ended_ = true;
  keep_first();
  for (const auto& stretch : stretches_) {
    roll_back(*stretch, 0);
    ++stretch->rollbacks;
    if (stretch->guess) stretch->guess->dropped = true;
  }
  stretches_.clear();
}

void SweepStretches::keep_first() {
  kept_ += stretches_.front()->entries.size();
  stretches_.pop_front();
}

/// Number of rows up to the first that is not finished.
std::size_t SweepStretches::known() const {
  if (stretches_.empty()) return kept_;
  const auto& entries = stretches_.front()->entries;
  const auto is_open = [](const auto& entry) { return !entry->done; };
  return kept_ + static_cast<std::size_t>(std::find_if(entries.begin(), entries.end(), is_open) - entries.begin());
}

std::vector<SweepRow> SweepStretches::so_far() const& {
  return {rows_.begin(), rows_.begin() + static_cast<std::ptrdiff_t>(known())};
}

std::vector<SweepRow> SweepStretches::so_far() && {
  rows_.resize(known());
  return std::move(rows_);
}

}  // namespace graze
