// SPDX-License-Identifier: GPL-3.0-or-later
// LaneMotion: a motion in lanes to be averaged (average.hpp), with its first tangent vector and the mean growth of its two
// directions.
//
// The vector is u' = Phi u. It is normalised only when its length has left [1e-3, 1e3]. Its growth over a period is
// ln|u'| - ln|u|, a difference of numbers below 7. The growth of the second direction is ln|det Phi| minus that of the first
// (the same numbers as from QR).
#pragma once

#include <graze/floquet/exponents/frame_motion.hpp>
#include <graze/floquet/exponents/motion_growth.hpp>
#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/numerics/log_product.hpp>

#include <array>
#include <span>

namespace graze {

class LaneMotion : public MotionGrowth<std::array<BatchMeans, 2>, std::array<bool, 2>> {
 public:
  explicit LaneMotion(const MotionStart& start) : MotionGrowth({}, {}, 0.0), at_(start) {}

  /// Adds the results of the next periods. Periods that are not `counted` only turn the vector.
  void add(std::span<const PeriodResult> results, bool counted, int interval);

  /// The same for periods without a tangent, which must precede all others.
  void pass(std::span<const PeriodResult> results);

  /// Present state of the motion.
  const MotionStart& at() const { return at_; }
  Vector state() const { return Vector{{at_.x, at_.v}}; }
  const ReturnTimes* times() const { return nullptr; }

 private:
  struct Growths;
  void shorten();
  void end_interval(int interval, Growths& growths);
  double log_length() const;

  MotionStart at_;
  double c_ = 1.0, s_ = 0.0;
  double log_before_ = 0.0;  // ln|u| at the last orthonormalisation, rescaled together with u
  LogProduct det_;           // since then, as is the integral of trace(f_x)
  double liouville_ = 0.0;
};

}  // namespace graze
