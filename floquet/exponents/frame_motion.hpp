// SPDX-License-Identifier: GPL-3.0-or-later
// FrameMotion: a motion of any system, carried by a Propagator, with a frame of tangent vectors that is orthonormalised every
// `interval` periods (formulas and sources: lyapunov.hpp).
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/floquet/exponents/motion_growth.hpp>
#include <graze/lib/motion/transition.hpp>
#include <graze/lib/numerics/batch_means.hpp>

#include <memory>
#include <vector>

namespace graze {

/// Tangent vectors, orthonormalised periodically. One that is lost, because the motion forgets a direction (rank of the
/// derivative), stays lost: the others span the image of the product of all derivatives.
class TangentFrame {
 public:
  explicit TangentFrame(std::size_t directions);

  void advance(const Matrix& Phi) {
    const auto kept = static_cast<Eigen::Index>(kept_);
    Q_.leftCols(kept) = Phi * Q_.leftCols(kept);
  }

  /// ln of the growth of each direction since the last call; -infinity for a lost one. `log_det`: ln|det| of the matrices since
  /// then, factor by factor, or not finite. With two directions it gives the second one, which next to grazing (stretched by
  /// 1/v) is lost to rounding in the product. `liouville`: the same from Liouville's identity. It gives the last direction
  /// where volumes shrink so much at once that this direction is lost to cancellation. `lost`: number of directions that are
  /// lost for sure (Transition::lost).
  const std::vector<double>& orthonormalise(double log_det, double liouville, int lost);

  /// Whether the last growths were computed from the matrices, so that their sum can be checked against Liouville's identity.
  bool is_measured() const { return is_measured_; }

 private:
  void orthonormalise_pair();
  void orthonormalise_kept(std::size_t lost);

  Matrix Q_;
  std::vector<double> growth_;
  std::size_t kept_;  ///< vectors that are not lost: the first ones
  bool is_measured_ = true;
};

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

/// A motion to be averaged (average.hpp), with a frame of as many tangent vectors as there are states.
class FrameMotion : public MotionGrowth<std::vector<BatchMeans>, std::vector<bool>> {
 public:
  /// @throws std::invalid_argument if the start is not admissible.
  FrameMotion(const SharedSystem& system, const AverageStart& start, const FlowOptions& flow);

  /// Carries the motion over the next periods. Periods that are not `counted` only turn the frame, and `parting` ones not even
  /// that.
  enum class Kind { counted, aligning, parting };
  void carry(std::size_t periods, Kind kind, int interval);

  const Vector& state() const { return state_; }
  const ReturnTimes* times() const { return forced_ ? nullptr : &times_; }

 private:
  void end_interval(int interval);

  bool forced_;
  std::unique_ptr<Propagator> propagator_;
  Transition transition_;
  Vector state_;
  TangentFrame frame_;
  double log_det_ = 0.0, liouville_ = 0.0, time_ = 0.0;  ///< since the last orthonormalisation
  int lost_now_ = 0;                                     ///< the same of Transition::lost
  ReturnTimes times_;
};

}  // namespace graze
