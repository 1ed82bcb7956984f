// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/exponents.hpp>
#include <graze/floquet/exponents/frame_average.hpp>

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace graze {

namespace {

double square(double x) { return x * x; }

/// The start, if the options and the start are valid. @throws std::invalid_argument otherwise.
const AverageStart& checked(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options) {
  validate(options);
  initial_mode(system, 0.0, start.state, start.p);
  return start;
}

}  // namespace

TangentFrame::TangentFrame(std::size_t directions)
    : Q_(Matrix::Identity(static_cast<Eigen::Index>(directions), static_cast<Eigen::Index>(directions))), growth_(directions) {}

const std::vector<double>& TangentFrame::orthonormalise(double log_det, double liouville) {
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

template <class Square> void TangentFrame::orthonormalise_with() {
  const Eigen::HouseholderQR<Square> qr{Square(Q_)};
  for (std::size_t i = 0; i < growth_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    growth_[i] = std::log(std::abs(qr.matrixQR()(k, k)));
  }
  const Square Q = qr.householderQ();
  Q_ = Q;
}

double ReturnTimes::error(std::size_t direction, const BatchMeans& growth, double rate) const {
  const double g = square(growth.standard_error()), t = square(times_.standard_error());
  if (!std::isfinite(g)) return g;
  const double both = square(sums_[direction].standard_error());
  return std::sqrt(std::max(0.0, g + rate * rate * t - rate * (both - g - t)));
}

FrameAverage::FrameAverage(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options)
    : system_(system), options_(options), forced_(is_forced(system)),
      forced_interval_(forced_ ? options.interval * forcing_period(system, start.p) : 0.0),
      propagator_(system, checked(system, start, options).p, {}, options.flow), frame_(system.states), means_(system.states),
      lost_(system.states, false), before_(system.states, 0.0), times_(system.states) {
  out_.state = start.state;
  out_.stop = LyapunovStop::budget;
}

double FrameAverage::exponent(std::size_t direction) const {
  return lost_[direction] ? -std::numeric_limits<double>::infinity() : means_[direction].mean() / interval_time();
}

double FrameAverage::standard_error(std::size_t direction) const {
  if (lost_[direction]) return 0.0;
  const BatchMeans& growth = means_[direction];
  const double own = forced_ ? growth.standard_error() : times_.error(direction, growth, exponent(direction));
  const double drift = forced_ ? growth.drift() : times_.drift(growth, exponent(direction));
  return with_trend(std::hypot(own, growth.edge()), drift) / interval_time();
}

/// Carries the motion and its frame over an interval. Empty if the motion ends in it.
std::optional<FrameAverage::Interval> FrameAverage::carry() {
  Interval sums;
  for (int period = 0; period < options_.interval; ++period) {
    carry_period(propagator_, out_.state, {.sensitivity = Sensitivity::state}, transition_);
    out_.termination = transition_.termination;
    if (transition_.termination != Termination::time) return std::nullopt;
    frame_.advance(transition_.Phi);
    sums.liouville += transition_.liouville;
    sums.log_det += transition_.log_det;
    sums.time += transition_.duration;
    out_.state = transition_.x1;
    if (aligned_ < options_.aligning) continue;
    for (const std::size_t event : transition_.event_sequence) out_.impacts += begins_contact(system_.events[event].kind) ? 1 : 0;
  }
  return sums;
}

void FrameAverage::carry_interval() {
  if (options_.cancelled && options_.cancelled()) return stop(LyapunovStop::interrupted);
  const std::optional<Interval> interval = carry();
  if (!interval) return stop(LyapunovStop::failed);
  add(*interval);
  if (out_.periods + options_.interval > options_.max_periods) open_ = false;
}

/// Adds the growths over an interval to the means, and applies the stop rule.
void FrameAverage::add(const Interval& interval) {
  const std::vector<double>& growth = frame_.orthonormalise(interval.log_det, interval.liouville);
  if (aligned_ < options_.aligning) {
    aligned_ += options_.interval;
    return;
  }
  if (!forced_) times_.add(interval.time);
  double largest_change = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < growth.size(); ++i) {
    lost_[i] = lost_[i] || !std::isfinite(growth[i]);
    sum += growth[i];
    if (lost_[i]) continue;
    means_[i].add(growth[i]);
    if (!forced_) times_.add_growth(i, growth[i]);
    const double now = exponent(i);
    largest_change = std::max(largest_change, std::abs(now - before_[i]));
    before_[i] = now;
  }
  out_.periods += options_.interval;
  out_.duration = times_.total();
  out_.log_growth = means_[0].total();
  out_.log_volume += interval.liouville;
  if (frame_.is_measured() && std::isfinite(sum) && std::isfinite(interval.liouville))
    out_.liouville_residual = std::max(out_.liouville_residual, std::abs(sum - interval.liouville) / options_.interval);
  if (options_.progress) options_.progress(out_.periods);
  look(largest_change);
}

void FrameAverage::look(double largest_change) {
  if (options_.change > 0.0 && out_.periods > options_.interval && largest_change < options_.change)
    return stop(LyapunovStop::change);
  const bool is_chaos = grows_beyond_shear(out_.log_growth, out_.log_volume, out_.periods);
  if (has_new_errors(options_, lost_[0], means_[0]) &&
      precise_enough(
          options_, out_.periods, is_chaos, means_.size(), [&](std::size_t i) { return exponent(i); },
          [&](std::size_t i) { return standard_error(i); }))
    stop(LyapunovStop::standard_error);
}

LyapunovSpectrum FrameAverage::result() && {
  const auto correlation = [&](std::size_t i) { return lost_[i] ? 0.0 : means_[i].correlation_time() * options_.interval; };
  write_exponents(
      means_.size(), [&](std::size_t i) { return exponent(i); }, [&](std::size_t i) { return standard_error(i); }, correlation,
      out_);
  return std::move(out_);
}

}  // namespace graze
