// SPDX-License-Identifier: GPL-3.0-or-later
// MotionGrowth: one motion of an average over motions (running_average.hpp), with the growth of its tangent directions so far.
#pragma once

#include <graze/floquet/exponents/tangents.hpp>
#include <graze/lib/numerics/batch_means.hpp>
#include <graze/lib/numerics/log_product.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

namespace graze {

/// Intervals of an autonomous motion have different times t. A rate is r = <g> / <t>, with g the growth of a direction; its
/// error is that of g - r t, over <t>. Batch means give the variance of a mean as a quadratic form V, so that
///     V(g - r t) = V(g) + r^2 V(t) - r (V(g + t) - V(g) - V(t)).
class ReturnTimes {
 public:
  explicit ReturnTimes(std::size_t directions) : sums_(directions) {}

  void add(double time) { times_.add(last_ = time); }
  /// Adds the growth in a direction, after the time of the same interval.
  void add_growth(std::size_t direction, double growth) { sums_[direction].add(growth + last_); }

  double mean() const { return times_.mean(); }
  double total() const { return times_.total(); }
  /// Standard error of the mean growth in a direction minus its rate times the mean time.
  double error(std::size_t direction, const BatchMeans& growth, double rate) const;
  double drift(const BatchMeans& growth, double rate) const { return growth.drift() - rate * times_.drift(); }

 private:
  BatchMeans times_;
  std::vector<BatchMeans> sums_;
  double last_ = 0.0;
};

class MotionGrowth {
 public:
  MotionGrowth(std::size_t states, bool is_forced);

  /// What the next periods are for: to part the motion from its neighbours (without tangent), to turn the tangents, to count.
  enum class Kind { parting, aligning, counted };
  /// Adds the next periods of the motion, and writes its state after them. The tangents are orthonormalised every `interval`
  /// counted periods.
  void add(const CarriedPeriods& periods, Kind kind, int interval, Vector& state);

  /// How the motion ended; `time`: it has not.
  Termination termination() const { return termination_; }
  /// Of an autonomous motion; null for a forced one.
  const ReturnTimes* times() const { return is_forced_ ? nullptr : &times_; }
  /// Means of the growth of a direction from one orthonormalisation to the next. A direction is lost if its growth was not finite
  /// (a vector that fell to zero, or NaN).
  const BatchMeans& means(std::size_t direction) const { return directions_[direction].means; }
  bool lost(std::size_t direction) const { return directions_[direction].lost; }
  /// Periods since the last orthonormalisation; averaged periods up to it; impacts in all counted periods.
  int periods_open() const { return periods_; }
  std::int64_t averaged() const { return averaged_; }
  std::int64_t impacts() const { return impacts_; }
  /// Liouville's sum over the averaged periods.
  double log_volume() const { return log_volume_; }
  /// Largest difference per period between ln|det| and Liouville's identity; -1: none was measured.
  double liouville_residual() const { return liouville_residual_; }

 private:
  template <class Tangents>
  void add_to(Tangents& tangents, const CarriedPeriods& periods, Kind kind, int interval, Vector& state);
  template <class Tangents> void end_interval(Tangents& tangents, int interval);
  void grown_to_means();

  bool is_forced_;
  Termination termination_ = Termination::time;
  std::variant<TangentPair, TangentFrame> tangents_;
  struct Direction {
    BatchMeans means;
    bool lost = false;
    std::array<double, 64> grown{};  ///< growths on their way to the means, together: half the time of one by one
    std::size_t count = 0;           ///< of these
  };
  std::vector<Direction> directions_;
  ReturnTimes times_;
  LogProduct determinant_;  ///< since the last orthonormalisation, as are these:
  double liouville_ = 0.0, time_ = 0.0;
  int lost_now_ = 0, periods_ = 0;
  std::int64_t averaged_ = 0, impacts_ = 0;
  double log_volume_ = 0.0, liouville_residual_ = -1.0;
};

}  // namespace graze
