// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/motion_growth.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

double square(double x) { return x * x; }

std::variant<TangentPair, TangentFrame> tangents_of(std::size_t states) {
  if (states == 2) return TangentPair();
  return TangentFrame(states);
}

}  // namespace

double ReturnTimes::error(std::size_t direction, const BatchMeans& growth, double rate) const {
  const double g = square(growth.standard_error()), t = square(times_.standard_error());
  if (!std::isfinite(g)) return g;
  const double both = square(sums_[direction].standard_error());
  return std::sqrt(std::max(0.0, g + rate * rate * t - rate * (both - g - t)));
}

MotionGrowth::MotionGrowth(std::size_t states, bool is_forced)
    : is_forced_(is_forced), tangents_(tangents_of(states)), directions_(states), times_(states) {}

void MotionGrowth::add(const CarriedPeriods& periods, Kind kind, int interval, Vector& state) {
  std::visit([&](auto& tangents) { add_to(tangents, periods, kind, interval, state); }, tangents_);
}

template <class Tangents>
void MotionGrowth::add_to(Tangents& tangents, const CarriedPeriods& periods, Kind kind, int interval, Vector& state) {
  std::size_t carried = 0;
  for (; carried < periods.size() && termination_ == Termination::time; ++carried) {
    termination_ = periods.termination(carried);
    if (termination_ != Termination::time) break;
    if (kind == Kind::aligning) tangents.align(periods, carried);
    if (kind != Kind::counted) continue;
    tangents.advance(periods, carried);
    periods.multiply_determinant(carried, determinant_);
    liouville_ += periods.liouville(carried);
    lost_now_ = std::max(lost_now_, periods.lost(carried));
    time_ += periods.duration(carried);
    impacts_ += periods.impacts(carried);
    if (++periods_ == interval) end_interval(tangents, interval);
  }
  if (carried > 0) periods.state(carried - 1, state);
  if (kind == Kind::aligning) tangents.begin_counting();
  grown_to_means();
}

template <class Tangents> void MotionGrowth::end_interval(Tangents& tangents, int interval) {
  const auto& growths = tangents.growths({determinant_.value(), liouville_, lost_now_});
  if (!is_forced_) times_.add(time_);
  for (std::size_t i = 0; i < growths.size(); ++i) {
    Direction& one = directions_[i];
    one.lost = one.lost || !std::isfinite(growths[i]);
    if (one.lost) continue;
    one.grown[one.count++] = growths[i];
    if (one.count == one.grown.size()) grown_to_means();
    if (!is_forced_) times_.add_growth(i, growths[i]);
  }
  averaged_ += interval;
  log_volume_ += liouville_;
  if (const double sum = tangents.measured_sum(); std::isfinite(sum) && std::isfinite(liouville_))
    liouville_residual_ = std::max(liouville_residual_, std::abs(sum - liouville_) / interval);
  determinant_ = {};
  liouville_ = time_ = 0.0;
  lost_now_ = periods_ = 0;
}

void MotionGrowth::grown_to_means() {
  for (Direction& one : directions_) {
    one.means.add(std::span(one.grown).first(one.count));
    one.count = 0;
  }
}

}  // namespace graze
