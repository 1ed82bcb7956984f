// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/follow/row.hpp>
#include <graze/floquet/follow/same_attractor.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace graze {

namespace {

/// Whether two consecutive points are periodic with the same n and p.
bool alike(const RowPoint& before, const RowPoint& point) {
  const Attractor &a = before.attractor, &b = point.attractor;
  return a.type == AttractorType::periodic && b.type == AttractorType::periodic && a.period == b.period &&
         a.impacts == b.impacts && before.states.size() == point.states.size();
}

}  // namespace

std::vector<PredictedOrbit> RowChain::predict(std::size_t, std::size_t, const std::vector<std::vector<Vector>>&) const {
  return {};
}

Row::Row(std::unique_ptr<const RowChain> chain, Listener listener, std::size_t most_guesses, std::vector<RowPoint> so_far)
    : chain_(std::move(chain)), listener_(std::move(listener)), most_guesses_(most_guesses) {
  done_ = kept_ = committed_ = so_far.size();
  if (finished()) return;
  // The stretch in progress. With no point after it, its last point has not been compared with a guess yet.
  kept_ = kept_ == 0 ? 0 : (kept_ - 1) / chain_->stretch() * chain_->stretch();
  Stretch& stretch = add_stretch(kept_);
  for (std::size_t k = kept_; k < done_; ++k) {
    const auto& known = stretch.entries.emplace_back(entry(stretch, {.number = k, .state = {}}));
    known->point = std::move(so_far[k]);
    known->published = known->done = true;
  }
}

std::size_t Row::stretch_of(std::size_t size) { return block_of(static_cast<std::size_t>(std::sqrt(size)) + block); }

Row::Stretch& Row::add_stretch(std::size_t begin) {
  return *stretches_.emplace_back(std::make_shared<Stretch>(begin, std::min(begin + chain_->stretch(), chain_->size())));
}

std::shared_ptr<Row::Entry> Row::entry(Stretch& stretch, RowChain::Begin begin) const {
  const std::size_t next = begin.number + 1;  // the last point of a stretch is compared with the guess
  begin.compared = next == stretch.begin || (next == stretch.end && next < chain_->size());
  return std::make_shared<Entry>(stretch, std::move(begin));
}

bool Row::can_go_on(const Stretch& stretch) const {
  if (stretch.predicting || stretch.ended || stretch.next() == stretch.end) return false;
  return stretch.next() == 0 || (stretch.last() && stretch.last()->published);
}

bool Row::likely(const Stretch& stretch) const {
  const bool is_guess = !stretch.joined && &stretch != stretches_.front().get();
  if (is_guess && !last_guess_accepted_) return false;
  const auto& entries = stretch.entries;
  if (entries.size() <= chain_->many()) return true;
  const auto is_open = [](const auto& entry) { return !entry->done; };
  const auto sure = std::find_if(entries.begin(), entries.end(), is_open) - entries.begin();
  return entries.size() - static_cast<std::size_t>(sure) <= chain_->many();
}

bool Row::can_guess() const {
  if (stretches_.empty() || stretches_.back()->end == chain_->size()) return false;
  const auto is_open = [](const auto& stretch) { return stretch->begin > 0 && !stretch->joined; };
  return static_cast<std::size_t>(std::count_if(stretches_.begin(), stretches_.end(), is_open)) < most_guesses_;
}

Row::Next Row::next() const {
  const auto stretch = stretch_to_continue();
  if (stretch) return likely(*stretch) ? Next::likely : Next::unlikely;
  return can_guess() ? Next::guess : Next::none;
}

std::shared_ptr<Row::Stretch> Row::stretch_to_continue() const {
  std::shared_ptr<Stretch> unlikely;
  for (const auto& stretch : stretches_) {
    if (!can_go_on(*stretch)) continue;
    if (likely(*stretch)) return stretch;
    if (!unlikely) unlikely = stretch;
  }
  return unlikely;
}

std::shared_ptr<Row::Entry> Row::start_guess() {
  Stretch& stretch = add_stretch(stretches_.back()->end);
  return stretch.lead = stretch.guess = entry(stretch, {.number = stretch.begin - 1, .state = {}});
}

bool Row::needs_prediction(const Stretch& stretch) const {
  const bool known = !stretch.last() || stretch.last()->done;
  return chain_->predicts() && known && stretch.predicted_block != block_of(stretch.next());
}

std::size_t Row::end_of_block(std::size_t begin) const { return std::min(begin + block, chain_->size()); }

std::vector<std::vector<Vector>> Row::orbits_before(const Stretch& stretch) const {
  const auto& entries = stretch.entries;
  const std::size_t begin = block_of(stretch.next());
  std::vector<std::vector<Vector>> before;
  for (std::size_t k = begin - stretch.begin; k > 0 && before.size() < most_orbits_before; --k) {
    const RowPoint &point = entries[k - 1]->point, &next = before.empty() ? point : entries[k]->point;
    if (!entries[k - 1]->done || !alike(point, next)) break;
    before.insert(before.begin(), point.states);
  }
  return before;
}

/// The next point, if its orbit was predicted.
std::optional<RowPoint> Row::predicted(Stretch& stretch) const {
  const std::size_t number = stretch.next(), place = number - block_of(number);
  const bool known = !stretch.last() || stretch.last()->done;
  if (!known || stretch.predicted_block != block_of(number) || place >= stretch.predicted_orbits.size()) return std::nullopt;
  PredictedOrbit& found = stretch.predicted_orbits[place];
  RowPoint point;
  describe_orbit(point.attractor, found.orbit);
  point.end = point.attractor.state;
  point.states = std::move(found.orbit.states);
  point.impact_speeds = std::move(found.impact_speeds);
  return point;
}

std::shared_ptr<Row::Entry> Row::start(Stretch& stretch) {
  std::optional<RowPoint> known = predicted(stretch);
  RowChain::Begin begin{.number = stretch.next(), .state = {}};
  if (const Entry* const last = stretch.last()) {
    begin.state = last->point.end;
    begin.settled = last->point.attractor.type == AttractorType::periodic;
  }
  const auto& next = stretch.entries.emplace_back(entry(stretch, std::move(begin)));
  if (!known) {
    ++stretch.open;
    return next;
  }
  std::shared_ptr<Entry> done = next;  // join() may remove the stretch
  done->point = std::move(*known);
  done->published = done->done = true;
  ++done_;
  join();
  return done;
}

void Row::publish(Entry& entry, const Vector& state) {
  if (entry.dropped) return;
  entry.point.end = state;
  entry.published = true;
}

void Row::finish(Entry& entry, RowChain::Found found) {
  if (entry.dropped) return;
  Stretch& stretch = *entry.stretch;
  const bool is_guess = stretch.guess.get() == &entry;
  const std::size_t behind = is_guess ? 0 : entry.begin.number + 1 - stretch.begin;
  if (found.failed) {
    roll_back(stretch, is_guess ? behind : behind - 1);
    if (is_guess)
      stretch.guess = stretch.lead = nullptr;
    else
      stretch.ended = true;
  } else {
    if (found.revokes) roll_back(stretch, behind);
    entry.point = std::move(found.point);
    entry.published = entry.done = true;
    if (!is_guess) {
      --stretch.open;
      ++done_;
    }
  }
  join();
}

/// Rolls back the points of a stretch from this one on, counted from its first.
void Row::roll_back(Stretch& stretch, std::size_t from) {
  if (stretch.done())  // its last point will change
    for (const auto& next : stretches_)
      if (next->begin == stretch.end) next->joined = false;
  stretch.ended = false;
  if (from >= stretch.entries.size()) return;
  ++stretch.rollbacks;
  stretch.predicted_block.reset();
  for (std::size_t k = from; k < stretch.entries.size(); ++k) {
    Entry& entry = *stretch.entries[k];
    entry.dropped = true;
    entry.done ? --done_ : --stretch.open;
  }
  stretch.entries.resize(from);
}

/// Links a stretch to the end of the one before. It keeps its guess if that is on the attractor of the last point there;
/// otherwise it starts again after that point.
void Row::follow(const std::shared_ptr<Entry>& last, Stretch& behind) {
  behind.joined = true;
  last_guess_accepted_ = behind.guess && on_same_attractor(last->point, behind.guess->point);
  if (last_guess_accepted_ && behind.lead == behind.guess) return;
  roll_back(behind, 0);
  behind.lead = last_guess_accepted_ ? behind.guess : last;
}

void Row::join() {
  for (std::size_t i = 0; i + 1 < stretches_.size(); ++i) {
    Stretch& behind = *stretches_[i + 1];
    if (stretches_[i]->done() && !behind.joined && (!behind.guess || behind.guess->done))
      follow(stretches_[i]->entries.back(), behind);
  }
  const auto nothing_can_change = [&] {
    return stretches_.front()->done() &&
           (stretches_.size() > 1 ? stretches_[1]->joined : stretches_.front()->end == chain_->size());
  };
  commit();
  while (!stretches_.empty() && nothing_can_change()) {
    keep_first();
    commit();
  }
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

/// Commits the points of the first stretch before the first that is not done.
void Row::commit() {
  if (stretches_.empty()) return;
  const auto& entries = stretches_.front()->entries;
  for (; committed_ - kept_ < entries.size() && entries[committed_ - kept_]->done; ++committed_)
    listener_.commit(committed_, entries[committed_ - kept_]->point);
}

void Row::keep_first() {
  kept_ += stretches_.front()->entries.size();
  stretches_.erase(stretches_.begin());
}

}  // namespace graze
