// SPDX-License-Identifier: GPL-3.0-or-later
// MapRow: a row of a map while its points are being found, each from where the one before has come to. A point that is not on an
// orbit when its transient is over hands its motion on then: what it is takes long to find out, and is found out beside those
// behind it. Should it end on a stable orbit after all, or nowhere, they are taken back. (As in a sweep: SweepStretches.)
#pragma once

#include <graze/floquet/follow/parameter_map.hpp>

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace graze {

class MapRow {
 public:
  struct Point {
    std::size_t number;          ///< in the order of the row
    std::optional<Vector> from;  ///< where the one before has come to; none: it begins anew
    bool handed_on = false, done = false;
    std::atomic<bool> dropped = false;  ///< one before it has turned out another
  };

  /// `out`: where its points go, in their order; they are not_run until they are done.
  explicit MapRow(std::span<MapPoint> out, bool backwards = false) : out_(out), backwards_(backwards) {}
  MapRow(MapRow&&) = default;

  /// Where in the row a point is.
  std::size_t place(const Point& point) const { return backwards_ ? out_.size() - 1 - point.number : point.number; }
  /// Whether the next point may begin, and if so, whether that is likely to be in vain: many before it are not done.
  enum class Next { none, likely, unlikely };
  Next next() const;
  /// Begins it.
  std::shared_ptr<Point> begin_next();
  /// That behind a point may begin, there.
  void hand_on(Point& point, const Vector& state);
  /// What a point is; not_run: it could not be found, and those behind it will not be. Returns how many points more nothing can
  /// change now.
  std::size_t finish(Point& point, MapPoint found);
  /// Whether nothing is left to do.
  bool finished() const { return sure_ == begun_.size() && (broken_ || sure_ == out_.size()); }

 private:
  void take_back(std::size_t from);

  std::span<MapPoint> out_;
  bool backwards_;
  std::vector<std::shared_ptr<Point>> begun_;
  std::optional<Vector> next_from_;
  std::size_t sure_ = 0;  ///< points at the beginning that are done
  bool broken_ = false;
};

}  // namespace graze
