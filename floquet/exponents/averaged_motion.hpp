// SPDX-License-Identifier: GPL-3.0-or-later
// AveragedMotion: one motion with its first tangent vector, and the means of what its two directions grow by.
//
// The vector is u' = Phi u, made short again only where its length has left [1e-3, 1e3]: a period grows it by ln|u'| - ln|u|, a
// difference of numbers below 7. What the second direction grows by is ln|det Phi| less that (the same numbers as from QR).
#pragma once

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

  /// What its next periods did to it. Those that are not `counted` turn the vector alone.
  void add(std::span<const PeriodResult> results, bool counted, int interval);

  /// The same of periods without a tangent, before all others.
  void pass(std::span<const PeriodResult> results);

  /// Where it is now.
  const MotionStart& at() const { return at_; }
  /// Of the growth of a direction from one orthonormalisation (`interval` periods) to the next; whether it is lost: it fell to
  /// zero, or is not a number.
  const BatchMeans& means(std::size_t direction) const { return means_[direction]; }
  bool lost(std::size_t direction) const { return lost_[direction]; }
  /// Periods since the last orthonormalisation; counted up to it; impacts in all that were counted.
  int periods_open() const { return periods_; }
  std::int64_t averaged() const { return averaged_; }
  std::int64_t impacts() const { return impacts_; }
  /// Liouville's sum over them.
  double log_volume() const { return log_volume_; }
  /// Largest difference per period between ln|det| and Liouville's identity.
  double liouville_residual() const { return liouville_residual_; }
  /// Other than `time`: it ended so.
  Termination termination() const { return termination_; }

 private:
  struct Growths;
  void shorten();
  void end_interval(int interval, Growths& growths);
  double log_length() const;

  MotionStart at_;
  double c_ = 1.0, s_ = 0.0;
  double log_before_ = 0.0;  // ln|u| at the last orthonormalisation, in terms of its present length
  LogProduct det_;           // since then, and the integral of trace(f_x)
  double liouville_ = 0.0;
  int periods_ = 0;
  std::array<BatchMeans, 2> means_;
  std::array<bool, 2> lost_{};
  std::int64_t averaged_ = 0, impacts_ = 0;
  double liouville_residual_ = 0.0, log_volume_ = 0.0;
  Termination termination_ = Termination::time;
};

}  // namespace graze
