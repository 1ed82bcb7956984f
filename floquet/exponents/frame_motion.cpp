// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/frame_motion.hpp>

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace graze {

namespace {

double square(double x) { return x * x; }

/// An orthogonal matrix without directions of its own: each of its columns has a part in every subspace of interest.
Matrix generic_frame(Eigen::Index directions) {
  std::mt19937 draw(1);
  const Matrix entries = Matrix::NullaryExpr(directions, directions, [&] { return static_cast<double>(draw()) * 0x1p-31 - 1.0; });
  return Eigen::HouseholderQR<Matrix>(entries).householderQ();
}

/// The part of each column that is orthogonal to those before it (the diagonal of R), relative to its length; 0 for a column that
/// vanishes.
Vector remainders(const Matrix& columns, const Eigen::HouseholderQR<Matrix>& qr) {
  const Vector lengths = columns.colwise().norm();
  return (lengths.array() > 0.0).select(qr.matrixQR().diagonal().cwiseAbs().cwiseQuotient(lengths), 0.0);
}

}  // namespace

TangentFrame::TangentFrame(std::size_t directions)
    : Q_(Matrix::Identity(static_cast<Eigen::Index>(directions), static_cast<Eigen::Index>(directions))), growth_(directions),
      kept_(directions) {}

const std::vector<double>& TangentFrame::orthonormalise(double log_det, double liouville, int lost) {
  is_measured_ = true;
  if (Q_.rows() == 2) {
    orthonormalise_pair();
    if (std::isfinite(log_det) && std::isfinite(growth_[0])) {
      growth_[1] = log_det - growth_[0];
      return growth_;
    }
  } else {
    orthonormalise_kept(static_cast<std::size_t>(lost));
  }
  const double others = std::accumulate(growth_.begin(), growth_.end() - 1, 0.0);
  constexpr double shrunk = 1e-3;  // relative to the first; below, the entries' own error (1e-13) would be visible
  const bool shrinks = kept_ == growth_.size() && lost == 0 && growth_.back() < growth_.front() + std::log(shrunk);
  if (shrinks && growth_.size() > 1 && std::isfinite(liouville) && std::isfinite(others)) {
    growth_.back() = liouville - others;
    is_measured_ = false;
  }
  return growth_;
}

void TangentFrame::orthonormalise_pair() {
  const Eigen::HouseholderQR<Eigen::Matrix2d> qr{Eigen::Matrix2d(Q_)};
  for (Eigen::Index k = 0; k < 2; ++k) growth_[static_cast<std::size_t>(k)] = std::log(std::abs(qr.matrixQR()(k, k)));
  const Eigen::Matrix2d Q = qr.householderQ();
  Q_ = Q;
}

void TangentFrame::orthonormalise_kept(std::size_t lost) {
  constexpr double rounding = 1e-10;  // of remainders
  const auto n = Q_.rows(), kept = static_cast<Eigen::Index>(kept_), left = n - static_cast<Eigen::Index>(lost);
  Eigen::HouseholderQR<Matrix> qr(Q_.leftCols(kept));
  Vector rest = remainders(Q_.leftCols(kept), qr);
  // The last vectors are lost, unless some states do not act on the others. Vectors of a generic frame before the loss would
  // have been mapped to Q_ times that frame.
  if (lost > 0 && left > 0 && kept == n && rest.head(left).minCoeff() <= rounding) {
    Q_ = Q_ * generic_frame(n);
    qr.compute(Q_);
    rest = remainders(Q_, qr);
  }
  const auto growth = qr.matrixQR().diagonal().cwiseAbs();
  const Eigen::Index most = std::max<Eigen::Index>(0, kept - static_cast<Eigen::Index>(lost));  // if all are lost anew
  Eigen::Index keeps = std::min(kept, left);
  while (keeps > most && rest[keeps - 1] <= rounding) --keeps;
  kept_ = static_cast<std::size_t>(keeps);
  std::fill(growth_.begin(), growth_.end(), -std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < kept_; ++i) growth_[i] = std::log(growth[static_cast<Eigen::Index>(i)]);
  Q_.leftCols(kept) = qr.householderQ() * Matrix::Identity(n, kept);
}

double ReturnTimes::error(std::size_t direction, const BatchMeans& growth, double rate) const {
  const double g = square(growth.standard_error()), t = square(times_.standard_error());
  if (!std::isfinite(g)) return g;
  const double both = square(sums_[direction].standard_error());
  return std::sqrt(std::max(0.0, g + rate * rate * t - rate * (both - g - t)));
}

FrameMotion::FrameMotion(const SharedSystem& system, const AverageStart& start, const FlowOptions& flow)
    : MotionGrowth(std::vector<BatchMeans>(system->states), std::vector<bool>(system->states, false), -1.0),
      forced_(is_forced(system)), propagator_(std::make_unique<Propagator>(system, start.p, std::vector<std::size_t>{}, flow)),
      state_(start.state), frame_(system->states), times_(system->states) {
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
    const std::vector<Event>& events = propagator_->system().events;
    for (const std::size_t event : transition_.event_sequence) impacts_ += begins_contact(events[event].kind) ? 1 : 0;
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
