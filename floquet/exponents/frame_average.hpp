// SPDX-License-Identifier: GPL-3.0-or-later
// FrameAverage: Lyapunov exponents along one motion of any system, carried by a Propagator, with a frame of tangent vectors that
// is orthonormalised every `interval` periods (formulas and sources: lyapunov.hpp).
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/lib/numerics/batch_means.hpp>

#include <vector>

namespace graze {

/// Tangent vectors, orthonormalised periodically.
class TangentFrame {
 public:
  explicit TangentFrame(std::size_t directions);

  void advance(const Matrix& Phi) { Q_ = Phi * Q_; }

  /// ln of the growth of each direction since the last call; -infinity for a lost one. `log_det`: ln|det| of the matrices since
  /// then, factor by factor, or not finite. With two directions it gives the second one, which next to grazing (stretched by
  /// 1/v) is lost to rounding in the product. `liouville`: the same from Liouville's identity. It gives the last direction
  /// where volumes shrink so much at once that this direction is lost to cancellation.
  const std::vector<double>& orthonormalise(double log_det, double liouville);

  /// Whether the last growths were computed from the matrices, so that their sum can be checked against Liouville's identity.
  bool is_measured() const { return is_measured_; }

 private:
  template <class Square> void orthonormalise_with();

  Matrix Q_;
  std::vector<double> growth_;
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

/// An average that is taken interval by interval.
class FrameAverage {
 public:
  /// Keeps references to the system and the options: keep them alive. @throws std::invalid_argument as lyapunov_spectrum does.
  FrameAverage(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options);

  /// Whether the options' rule asks for another interval.
  bool open() const { return open_; }
  void carry_interval();
  std::int64_t periods() const { return out_.periods; }
  const Vector& state() const { return out_.state; }
  LyapunovSpectrum result() &&;

 private:
  /// Sums over an interval.
  struct Interval {
    double log_det = 0.0, liouville = 0.0, time = 0.0;
  };
  std::optional<Interval> carry();
  void add(const Interval& interval);
  void look(double largest_change);
  void stop(LyapunovStop reason) {
    out_.stop = reason;
    open_ = false;
  }
  double interval_time() const { return forced_ ? forced_interval_ : times_.mean(); }
  double exponent(std::size_t direction) const;
  double standard_error(std::size_t direction) const;

  const HybridSystem& system_;
  const LyapunovOptions& options_;
  bool forced_;
  double forced_interval_;
  Propagator propagator_;
  Transition transition_;
  TangentFrame frame_;
  std::vector<BatchMeans> means_;  ///< of the growth of each direction in an interval
  std::vector<bool> lost_;
  std::vector<double> before_;  ///< exponents after the interval before
  ReturnTimes times_;
  std::int64_t aligned_ = 0;
  bool open_ = true;
  LyapunovSpectrum out_;
};

}  // namespace graze
