// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/tangents.hpp>

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

namespace graze {

namespace {

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

void TangentPair::shorten() {
  const double length = std::hypot(c_, s_);
  const bool is_direction = length > 0.0 && std::isfinite(length);
  log_before_ = is_direction ? log_before_ - std::log(length) : std::numeric_limits<double>::infinity();
  c_ = is_direction ? c_ / length : 1.0;
  s_ = is_direction ? s_ / length : 0.0;
}

TangentFrame::TangentFrame(std::size_t directions)
    : Q_(Matrix::Identity(static_cast<Eigen::Index>(directions), static_cast<Eigen::Index>(directions))), growth_(directions),
      kept_(directions) {}

void TangentFrame::advance(const CarriedPeriods& periods, std::size_t k) {
  const auto kept = static_cast<Eigen::Index>(kept_);
  Q_.leftCols(kept) = periods.tangent_map(k) * Q_.leftCols(kept);
}

void TangentFrame::align(const CarriedPeriods& periods, std::size_t k) {
  advance(periods, k);
  orthonormalise(static_cast<std::size_t>(periods.lost(k)));
}

std::span<const double> TangentFrame::growths(const VolumeChange& change) {
  orthonormalise(static_cast<std::size_t>(change.lost));
  const double others = std::accumulate(growth_.begin(), growth_.end() - 1, 0.0);
  measured_sum_ = others + growth_.back();
  constexpr double shrunk = 1e-3;  // relative to the first; below, the entries' own error (1e-13) would be visible
  const bool shrinks = kept_ == growth_.size() && change.lost == 0 && growth_.back() < growth_.front() + std::log(shrunk);
  if (shrinks && growth_.size() > 1 && std::isfinite(change.liouville) && std::isfinite(others)) {
    growth_.back() = change.liouville - others;
    measured_sum_ = std::numeric_limits<double>::quiet_NaN();
  }
  return growth_;
}

void TangentFrame::orthonormalise(std::size_t lost) {
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

}  // namespace graze
