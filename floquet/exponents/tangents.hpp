// SPDX-License-Identifier: GPL-3.0-or-later
// Tangent vectors of a motion to be averaged (motion_growth.hpp), orthonormalised periodically (formulas and sources:
// lyapunov.hpp): as many as there are states. TangentPair is TangentFrame for two states, without matrices.
#pragma once

#include <graze/lib/numerics/vector.hpp>
#include <graze/lib/tasks/carried_periods.hpp>

#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

namespace graze {

/// ln|det| of the maps since the last orthonormalisation, factor by factor; the same from Liouville's identity; and the number of
/// directions lost for sure in one of them (Transition::lost).
struct VolumeChange {
  double log_det = 0.0, liouville = 0.0;
  int lost = 0;
};

/// Of two directions the first is carried along, u' = Phi u. It is normalised only when its length has left [1e-3, 1e3]. Its
/// growth is ln|u'| - ln|u|, a difference of numbers below 7. The growth of the second is ln|det Phi| minus that of the first:
/// the same numbers as from QR, also next to a grazing, where the second vector (stretched by 1/v) would be lost to rounding in
/// the product.
class TangentPair {
 public:
  void advance(const CarriedPeriods& periods, std::size_t k) {
    const std::array<double, 4> Phi = periods.tangent_map_of_two(k);
    const double c = c_, s = s_;
    c_ = Phi[0] * c + Phi[1] * s;
    s_ = Phi[2] * c + Phi[3] * s;
    constexpr double longest = 1e3;
    if (const double square = c_ * c_ + s_ * s_; !(square < longest * longest && square > 1.0 / (longest * longest))) shorten();
  }
  void align(const CarriedPeriods& periods, std::size_t k) { advance(periods, k); }
  /// The growths are counted from here on.
  void begin_counting() { log_before_ = log_length(); }
  /// ln of the growth of each direction since the last call, which are orthonormal again; not finite for a lost one.
  const std::array<double, 2>& growths(const VolumeChange& change) {
    const double log_now = log_length(), first = log_now - log_before_;
    const bool is_measured = std::isfinite(change.log_det);
    growths_ = {first, (is_measured ? change.log_det : change.liouville) - first};
    measured_sum_ = is_measured ? change.log_det : std::numeric_limits<double>::quiet_NaN();
    log_before_ = log_now;
    return growths_;
  }
  /// The sum of the last growths, for a check against Liouville's identity; NaN if it was computed from that identity.
  double measured_sum() const { return measured_sum_; }

 private:
  double log_length() const { return 0.5 * std::log(c_ * c_ + s_ * s_); }
  void shorten();

  double c_ = 1.0, s_ = 0.0;
  double log_before_ = 0.0;  ///< ln|u| at the last orthonormalisation, rescaled together with u
  std::array<double, 2> growths_{};
  double measured_sum_ = 0.0;
};

/// Any number of directions. One that is lost, because the motion forgets it (rank of the derivative), stays lost: the others
/// span the image of the product of all derivatives.
class TangentFrame {
 public:
  explicit TangentFrame(std::size_t directions);

  void advance(const CarriedPeriods& periods, std::size_t k);
  void align(const CarriedPeriods& periods, std::size_t k);
  void begin_counting() {}
  /// As TangentPair's; -infinity for a lost direction. The last one is that of Liouville's identity where volumes shrink so much
  /// at once that this direction is lost to cancellation.
  std::span<const double> growths(const VolumeChange& change);
  double measured_sum() const { return measured_sum_; }

 private:
  void orthonormalise(std::size_t lost);

  Matrix Q_;
  std::vector<double> growth_;
  std::size_t kept_;  ///< vectors that are not lost: the first ones
  double measured_sum_ = 0.0;
};

}  // namespace graze
