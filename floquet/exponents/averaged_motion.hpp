// SPDX-License-Identifier: GPL-3.0-or-later
// AveragedMotion: a motion in lanes to be averaged (average.hpp), with its first tangent vector and the mean growth of its two
// directions.
//
// The vector is u' = Phi u. It is normalised only when its length has left [1e-3, 1e3]. Its growth over a period is
// ln|u'| - ln|u|, a difference of numbers below 7. The growth of the second direction is ln|det Phi| minus that of the first
// (the same numbers as from QR).
#pragma once

#include <graze/floquet/exponents/frame_motion.hpp>
#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/numerics/batch_means.hpp>
#include <graze/lib/numerics/log_product.hpp>

#include <array>
#include <cstdint>
#include <span>

namespace graze {

class AveragedMotion {
 public:
  explicit AveragedMotion(const MotionStart& start) : at_(start) {}

  /// Adds the results of the next periods. Periods that are not `counted` only turn the vector.
  void add(std::span<const PeriodResult> results, bool counted, int interval);

  /// The same for periods without a tangent, which must precede all others.
  void pass(std::span<const PeriodResult> results);

  /// Present state of the motion.
  const MotionStart& at() const { return at_; }
  Vector state() const { return Vector{{at_.x, at_.v}}; }
  /// Means of the growth of a direction from one orthonormalisation (`interval` periods) to the next. A direction is lost if
  /// its growth was not finite (a vector that fell to zero, or NaN).
  const BatchMeans& means(std::size_t direction) const { return means_[direction]; }
  bool lost(std::size_t direction) const { return lost_[direction]; }
  /// Periods since the last orthonormalisation; averaged periods up to it; impacts in all counted periods.
  int periods_open() const { return periods_; }
  std::int64_t averaged() const { return averaged_; }
  std::int64_t impacts() const { return impacts_; }
  /// Liouville's sum over the averaged periods.
  double log_volume() const { return log_volume_; }
  /// Largest difference per period between ln|det| and Liouville's identity.
  double liouville_residual() const { return liouville_residual_; }
  /// How the motion ended; `time`: it has not.
  Termination termination() const { return termination_; }
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
  int periods_ = 0;
  std::array<BatchMeans, 2> means_;
  std::array<bool, 2> lost_{};
  std::int64_t averaged_ = 0, impacts_ = 0;
  double liouville_residual_ = 0.0, log_volume_ = 0.0;
  Termination termination_ = Termination::time;
};

}  // namespace graze
