// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/exponents.hpp>
#include <graze/floquet/exponents/lyapunov_lanes.hpp>
#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/numerics/batch_means.hpp>

#include <fmt/format.h>

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace graze {

namespace {

/// Tangent vectors, orthonormalised periodically.
class Frame {
 public:
  explicit Frame(Eigen::Index n) : Q_(Matrix::Identity(n, n)), growth_(static_cast<std::size_t>(n)) {}

  void advance(const Matrix& Phi) { Q_ = Phi * Q_; }

  /// ln of the growth of each direction since the last call; -infinity for a lost one. `log_det`: ln|det| of the matrices since
  /// then, factor by factor, or not finite. With two directions it gives the second one, which next to grazing (stretched by
  /// 1/v) is lost to rounding in the product. `liouville`: the same from Liouville's identity. It gives the last direction
  /// where volumes shrink so much at once that this direction is lost to cancellation.
  const std::vector<double>& orthonormalise(double log_det, double liouville) {
    is_measured_ = true;
    if (Q_.rows() == 2) {
      orthonormalise_with<Eigen::Matrix2d>();
      if (std::isfinite(log_det) && std::isfinite(growth_[0])) {
        growth_[1] = log_det - growth_[0];
        return growth_;
      }
    } else {
      orthonormalise_with<Matrix>();
    }
    const double others = std::accumulate(growth_.begin(), growth_.end() - 1, 0.0);
    constexpr double shrunk = 1e-3;  // relative to the first; below, the entries' own error (1e-13) would be visible
    const bool shrinks = growth_.back() < growth_.front() + std::log(shrunk);
    if (shrinks && growth_.size() > 1 && std::isfinite(liouville) && std::isfinite(others)) {
      growth_.back() = liouville - others;
      is_measured_ = false;
    }
    return growth_;
  }

  /// Whether the last growths were computed from the matrices, so that their sum can be checked against Liouville's identity.
  bool is_measured() const { return is_measured_; }

 private:
  template <class Square> void orthonormalise_with() {
    const Eigen::HouseholderQR<Square> qr{Square(Q_)};
    for (std::size_t i = 0; i < growth_.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      growth_[i] = std::log(std::abs(qr.matrixQR()(k, k)));
    }
    const Square Q = qr.householderQ();
    Q_ = Q;
  }

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
  double error(std::size_t direction, const BatchMeans& growth, double rate) const {
    const double g = square(growth.standard_error()), t = square(times_.standard_error());
    if (!std::isfinite(g)) return g;
    const double both = square(sums_[direction].standard_error());
    return std::sqrt(std::max(0.0, g + rate * rate * t - rate * (both - g - t)));
  }
  double drift(const BatchMeans& growth, double rate) const { return growth.drift() - rate * times_.drift(); }

 private:
  static double square(double x) { return x * x; }

  BatchMeans times_;
  std::vector<BatchMeans> sums_;
  double last_ = 0.0;
};

}  // namespace

void validate(const LyapunovOptions& options) {
  if (options.interval < 1)
    throw std::invalid_argument(fmt::format("interval is {}; allowed is a whole number >= 1", options.interval));
  if (options.motions < 1)
    throw std::invalid_argument(fmt::format("motions is {}; allowed is a whole number >= 1", options.motions));
  if (options.aligning < 0)
    throw std::invalid_argument(fmt::format("aligning is {}; allowed is a whole number >= 0", options.aligning));
  if (options.max_periods < options.interval)
    throw std::invalid_argument(
        fmt::format("max_periods is {}; allowed is at least the interval, {}", options.max_periods, options.interval));
  if (!(options.standard_error >= 0.0) || !(options.change >= 0.0) || !(options.significance >= 0.0))
    throw std::invalid_argument("the bounds of standard error, significance and change must be >= 0");
}

std::string_view lyapunov_stop_text(LyapunovStop reason) {
  switch (reason) {
  case LyapunovStop::not_run:
    return "it was not run";
  case LyapunovStop::standard_error:
    return "every standard error is below its bound";
  case LyapunovStop::change:
    return "the exponents changed by less than the bound from one orthonormalisation to the next";
  case LyapunovStop::budget:
    return "the budget of forcing periods is used up";
  case LyapunovStop::interrupted:
    return "it was interrupted";
  case LyapunovStop::failed:
    return "the motion could not be carried on";
  }
  return "";
}

double period_time(const HybridSystem& system, const Vector& p, const LyapunovSpectrum& average) {
  return is_forced(system) ? forcing_period(system, p) : average.duration / static_cast<double>(average.periods);
}

double kaplan_yorke_dimension(const std::vector<double>& exponents) {
  double sum = 0.0;
  for (std::size_t j = 0; j < exponents.size(); ++j) {
    if (sum + exponents[j] < 0.0) return static_cast<double>(j) + (std::isfinite(exponents[j]) ? sum / -exponents[j] : 0.0);
    sum += exponents[j];
  }
  return static_cast<double>(exponents.size());
}

LyapunovSpectrum lyapunov_spectrum(const HybridSystem& system, const Vector& p, const Vector& state,
                                   const LyapunovOptions& options) {
  validate(options);
  if (options.motions > 1 && LaneCarrier::applies(system, p, options.flow)) return lane_spectrum(system, {p, state}, options);
  initial_mode(system, 0.0, state, p);
  LyapunovSpectrum out;
  out.state = state;
  const auto n = static_cast<Eigen::Index>(system.states);
  const bool forced = is_forced(system);
  const double forced_interval = forced ? options.interval * forcing_period(system, p) : 0.0;
  Propagator propagator(system, p, {}, options.flow);
  Transition transition;
  Frame frame(n);
  std::vector<BatchMeans> means(static_cast<std::size_t>(n));
  std::vector<bool> lost(static_cast<std::size_t>(n), false);
  std::vector<double> before(static_cast<std::size_t>(n), 0.0);
  ReturnTimes times(static_cast<std::size_t>(n));
  const auto interval_time = [&] { return forced ? forced_interval : times.mean(); };
  const auto exponent = [&](std::size_t i) {
    return lost[i] ? -std::numeric_limits<double>::infinity() : means[i].mean() / interval_time();
  };
  const auto error = [&](std::size_t i) {
    if (lost[i]) return 0.0;
    const double own = forced ? means[i].standard_error() : times.error(i, means[i], exponent(i));
    const double drift = forced ? means[i].drift() : times.drift(means[i], exponent(i));
    return with_trend(std::hypot(own, means[i].edge()), drift) / interval_time();
  };
  out.stop = LyapunovStop::budget;
  std::int64_t aligned = 0;
  while (out.periods + options.interval <= options.max_periods) {
    if (options.cancelled && options.cancelled()) {
      out.stop = LyapunovStop::interrupted;
      break;
    }
    double liouville = 0.0, log_det = 0.0, sum = 0.0, time = 0.0;
    bool carried = true;
    for (int period = 0; period < options.interval && carried; ++period) {
      carry_period(propagator, out.state, {.sensitivity = Sensitivity::state}, transition);
      out.termination = transition.termination;
      carried = transition.termination == Termination::time;
      if (!carried) break;
      frame.advance(transition.Phi);
      liouville += transition.liouville;
      log_det += transition.log_det;
      time += transition.duration;
      out.state = transition.x1;
      if (aligned < options.aligning) continue;
      for (const std::size_t event : transition.event_sequence) out.impacts += begins_contact(system.events[event].kind) ? 1 : 0;
    }
    if (!carried) {
      out.stop = LyapunovStop::failed;
      break;
    }
    const std::vector<double>& growth = frame.orthonormalise(log_det, liouville);
    if (aligned < options.aligning) {
      aligned += options.interval;
      continue;
    }
    if (!forced) times.add(time);
    double largest_change = 0.0;
    for (std::size_t i = 0; i < growth.size(); ++i) {
      lost[i] = lost[i] || !std::isfinite(growth[i]);
      sum += growth[i];
      if (lost[i]) continue;
      means[i].add(growth[i]);
      if (!forced) times.add_growth(i, growth[i]);
      const double now = exponent(i);
      largest_change = std::max(largest_change, std::abs(now - before[i]));
      before[i] = now;
    }
    out.periods += options.interval;
    out.duration = times.total();
    out.log_growth = means[0].total();
    out.log_volume += liouville;
    if (frame.is_measured() && std::isfinite(sum) && std::isfinite(liouville))
      out.liouville_residual = std::max(out.liouville_residual, std::abs(sum - liouville) / options.interval);
    if (options.progress) options.progress(out.periods);
    if (options.change > 0.0 && out.periods > options.interval && largest_change < options.change) {
      out.stop = LyapunovStop::change;
      break;
    }
    const bool is_chaos = grows_beyond_shear(out.log_growth, out.log_volume, out.periods);
    if (has_new_errors(options, lost[0], means[0]) &&
        precise_enough(options, out.periods, is_chaos, means.size(), exponent, error)) {
      out.stop = LyapunovStop::standard_error;
      break;
    }
  }
  const auto correlation = [&](std::size_t i) { return lost[i] ? 0.0 : means[i].correlation_time() * options.interval; };
  write_exponents(means.size(), exponent, error, correlation, out);
  return out;
}

}  // namespace graze
