// SPDX-License-Identifier: GPL-3.0-or-later
// MapRow: a row of a map during its computation; each point starts from the end state of the one before. A point that is not on
// an orbit after its transient publishes its state early: classifying it takes long and proceeds in parallel with the points
// after it. If it ends on a stable orbit after all, or on nothing, the points after it are rolled back. (As in a sweep:
// SweepStretches.)
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
    std::size_t number;          ///< in the order of computation
    std::optional<Vector> from;  ///< end state of the previous point; none: starts anew
    bool published = false, done = false;
    std::atomic<bool> dropped = false;  ///< rolled back: an earlier point ended elsewhere
  };

  /// `out`: receives the points in column order; they are not_run until they are done.
  explicit MapRow(std::span<MapPoint> out, bool backwards = false) : out_(out), backwards_(backwards) {}
  MapRow(MapRow&&) = default;

  /// Index of a point in the row.
  std::size_t place(const Point& point) const { return backwards_ ? out_.size() - 1 - point.number : point.number; }
  /// Whether the next point can start, and if so, whether it will probably be rolled back: many points before it are not done.
  enum class Next { none, likely, unlikely };
  Next next() const;
  /// Starts the next point.
  std::shared_ptr<Point> begin_next();
  /// Publishes the state of a point: the next one can start from there.
  void publish(Point& point, const Vector& state);
  /// Stores the result of a point. not_run: it could not be computed, which ends the row. Returns the number of points that
  /// this commits.
  std::size_t finish(Point& point, MapPoint found);
  /// Whether all points are committed, or the row has ended.
  bool finished() const { return sure_ == begun_.size() && (broken_ || sure_ == out_.size()); }

 private:
  void roll_back(std::size_t from);

  std::span<MapPoint> out_;
  bool backwards_;
  std::vector<std::shared_ptr<Point>> begun_;
  std::optional<Vector> next_from_;
  std::size_t sure_ = 0;  ///< committed points: they and all before them are done
  bool broken_ = false;
};

}  // namespace graze
