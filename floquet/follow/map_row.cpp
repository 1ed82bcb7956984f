// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/follow/map_row.hpp>

#include <utility>

namespace graze {

namespace {

/// If more points than this are open or follow an open one, the next will probably be rolled back.
constexpr std::size_t many = 4;

}  // namespace

MapRow::Next MapRow::next() const {
  if (broken_ || begun_.size() == out_.size()) return Next::none;
  if (!begun_.empty() && !begun_.back()->published && !begun_.back()->done) return Next::none;
  return begun_.size() - sure_ > many ? Next::unlikely : Next::likely;
}

std::shared_ptr<MapRow::Point> MapRow::begin_next() {
  return begun_.emplace_back(std::make_shared<Point>(begun_.size(), next_from_));
}

void MapRow::publish(Point& point, const Vector& state) {
  if (point.dropped) return;
  point.published = true;
  next_from_ = state;
}

std::size_t MapRow::finish(Point& point, MapPoint found) {
  if (point.dropped) return 0;
  if (found.type == MapType::not_run) {
    broken_ = true;
    roll_back(point.number);
    return 0;
  }
  const bool arrived = found.type != MapType::inadmissible && found.type != MapType::lost;
  if (!point.published || !arrived || found.type == MapType::periodic) {
    roll_back(point.number + 1);
    next_from_ = arrived ? std::optional(found.state) : std::nullopt;
  }
  point.done = true;
  out_[place(point)] = std::move(found);
  const std::size_t before = sure_;
  while (sure_ < begun_.size() && begun_[sure_]->done) ++sure_;
  return sure_ - before;
}

/// Rolls back the points from this number on.
void MapRow::roll_back(std::size_t from) {
  for (std::size_t k = from; k < begun_.size(); ++k) {
    begun_[k]->dropped = true;
    out_[place(*begun_[k])] = {};
  }
  begun_.resize(from);
}

}  // namespace graze
