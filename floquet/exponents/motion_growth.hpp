// SPDX-License-Identifier: GPL-3.0-or-later
// MotionGrowth: the growth of the tangent directions of one motion so far, for an average over motions (average.hpp).
#pragma once

#include <graze/lib/numerics/batch_means.hpp>
#include <graze/lib/system/termination.hpp>

#include <cstddef>
#include <cstdint>
#include <utility>

namespace graze {

/// `Means` and `Flags`: containers of BatchMeans and bool, one entry a direction.
template <class Means, class Flags> class MotionGrowth {
 public:
  /// How the motion ended; `time`: it has not.
  Termination termination() const { return termination_; }
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

 protected:
  MotionGrowth(Means means, Flags lost, double liouville_residual)
      : means_(std::move(means)), lost_(std::move(lost)), liouville_residual_(liouville_residual) {}

  Termination termination_ = Termination::time;
  Means means_;
  Flags lost_;
  int periods_ = 0;
  std::int64_t averaged_ = 0, impacts_ = 0;
  double log_volume_ = 0.0, liouville_residual_;
};

}  // namespace graze
