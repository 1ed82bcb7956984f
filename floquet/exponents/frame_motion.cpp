// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/frame_motion.hpp>

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace graze {

namespace {

double square(double x) { return x * x; }

}  // namespace

TangentFrame::TangentFrame(std::size_t directions)
    : Q_(Matrix::Identity(static_cast<Eigen::Index>(directions), static_cast<Eigen::Index>(directions))), growth_(directions) {}

const std::vector<double>& TangentFrame::orthonormalise(double log_det, double liouville, int lost) {
  is_measured_ = true;
  if (Q_.rows() == 2) {
    orthonormalise_with<Eigen::Matrix2d>();
    if (std::isfinite(log_det) && std::isfinite(growth_[0])) {
      growth_[1] = log_det - growth_[0];
      return growth_;
    }
  } else {
    orthonormalise_with<Matrix>();
    std::fill(growth_.end() - lost, growth_.end(), -std::numeric_limits<double>::infinity());  // in place of rounding
  }
  const double others = std::accumulate(growth_.begin(), growth_.end() - 1, 0.0);
  constexpr double shrunk = 1e-3;  // relative to the first; below, the entries' own error (1e-13) would be visible
  const bool shrinks = lost == 0 && growth_.back() < growth_.front() + std::log(shrunk);
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

FrameMotion::FrameMotion(const HybridSystem& system, const AverageStart& start, const FlowOptions& flow)
    : MotionGrowth(std::vector<BatchMeans>(system.states), std::vector<bool>(system.states, false), -1.0), system_(&system),
      forced_(is_forced(system)), propagator_(std::make_unique<Propagator>(system, start.p, std::vector<std::size_t>{}, flow)),
      state_(start.state), frame_(system.states), times_(system.states) {
  initial_mode(system, 0.0, start.state, start.p);
}

void FrameMotion::carry(std::size_t periods, Kind kind, int interval) {
  const Sensitivity sensitivity = kind == Kind::parting ? Sensitivity::none : Sensitivity::state;
  for (std::size_t k = 0; k < periods && termination_ == Termination::time; ++k) {
    carry_period(*propagator_, state_, {.sensitivity = sensitivity}, transition_);
    termination_ = transition_.termination;
    if (termination_ != Termination::time) return;
    state_ = transition_.x1;
    if (kind == Kind::parting) continue;
    frame_.advance(transition_.Phi);
    if (kind == Kind::aligning) {
      frame_.orthonormalise(transition_.log_det, transition_.liouville, transition_.lost);
      continue;
    }
    log_det_ += transition_.log_det;
    liouville_ += transition_.liouville;
    lost_now_ = std::max(lost_now_, transition_.lost);
    time_ += transition_.duration;
    for (const std::size_t event : transition_.event_sequence) impacts_ += begins_contact(system_->events[event].kind) ? 1 : 0;
    if (++periods_ == interval) end_interval(interval);
  }
}

void FrameMotion::end_interval(int interval) {
  const std::vector<double>& growth = frame_.orthonormalise(log_det_, liouville_, lost_now_);
  if (!forced_) times_.add(time_);
  double sum = 0.0;
  for (std::size_t i = 0; i < growth.size(); ++i) {
    lost_[i] = lost_[i] || !std::isfinite(growth[i]);
    sum += growth[i];
    if (lost_[i]) continue;
    means_[i].add(growth[i]);
    if (!forced_) times_.add_growth(i, growth[i]);
  }
  averaged_ += interval;
  log_volume_ += liouville_;
  if (frame_.is_measured() && std::isfinite(sum) && std::isfinite(liouville_))
    liouville_residual_ = std::max(liouville_residual_, std::abs(sum - liouville_) / interval);
  log_det_ = liouville_ = time_ = 0.0;
  lost_now_ = 0;
  periods_ = 0;
}

}  // namespace graze
