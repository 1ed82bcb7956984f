// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/lane_motion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

/// Buffer for the growths before they are added to the means.
struct LaneMotion::Growths {
  std::array<std::array<double, 64>, 2> values;
  std::array<std::size_t, 2> count{};
};

double LaneMotion::log_length() const { return 0.5 * std::log(c_ * c_ + s_ * s_); }

void LaneMotion::shorten() {
  const double length = std::hypot(c_, s_);
  const bool is_direction = length > 0.0 && std::isfinite(length);
  log_before_ = is_direction ? log_before_ - std::log(length) : std::numeric_limits<double>::infinity();
  c_ = is_direction ? c_ / length : 1.0;
  s_ = is_direction ? s_ / length : 0.0;
}

void LaneMotion::end_interval(int interval, Growths& growths) {
  const double log_det = det_.value(), log_now = log_length(), first = log_now - log_before_;
  const std::array<double, 2> grown = {first, (std::isfinite(log_det) ? log_det : liouville_) - first};
  for (std::size_t i = 0; i < 2; ++i) {
    lost_[i] = lost_[i] || !std::isfinite(grown[i]);
    if (!lost_[i]) growths.values[i][growths.count[i]++] = grown[i];
  }
  if (std::isfinite(log_det) && std::isfinite(liouville_))
    liouville_residual_ = std::max(liouville_residual_, std::abs(log_det - liouville_) / interval);
  averaged_ += interval;
  log_volume_ += liouville_;
  log_before_ = log_now;
  det_ = {};
  liouville_ = 0.0;
  periods_ = 0;
}

void LaneMotion::pass(std::span<const PeriodResult> results) {
  // If one period ends early, the later ones have the same termination.
  termination_ = results.back().termination;
  if (termination_ != Termination::time) return;
  at_.x = results.back().x;
  at_.v = results.back().v;
}

void LaneMotion::add(std::span<const PeriodResult> results, bool counted, int interval) {
  Growths growths;
  const auto to_means = [&] {
    for (std::size_t i = 0; i < 2; ++i) {
      means_[i].add(std::span(growths.values[i]).first(growths.count[i]));
      growths.count[i] = 0;
    }
  };
  for (const PeriodResult& period : results) {
    if (termination_ == Termination::time) termination_ = period.termination;
    if (termination_ != Termination::time) break;
    at_.x = period.x;
    at_.v = period.v;
    const double c = c_, s = s_;
    c_ = period.Phi[0] * c + period.Phi[1] * s;
    s_ = period.Phi[2] * c + period.Phi[3] * s;
    constexpr double longest = 1e3;
    if (const double square = c_ * c_ + s_ * s_; !(square < longest * longest && square > 1.0 / (longest * longest))) shorten();
    if (!counted) continue;
    det_.multiply(period.det);
    liouville_ += period.liouville;
    impacts_ += period.impacts;
    if (++periods_ < interval) continue;
    end_interval(interval, growths);
    if (std::max(growths.count[0], growths.count[1]) == growths.values[0].size()) to_means();
  }
  to_means();
  if (!counted) log_before_ = log_length();
}

}  // namespace graze
