// SPDX-License-Identifier: GPL-3.0-or-later
// DistanceWatch: decides from a few samples of the distance whether a motion approaches a stable orbit.
#pragma once

#include <algorithm>
#include <cmath>

namespace graze {

/// Takes a sample of the distance each time the orbit's slowest multiplier should have halved it. The motion approaches the
/// orbit if a sample is below 3/4 of the initial distance. If the tangent is far from normal this may take several samples:
/// sample k must be below (3/4)^k. A motion that starts far away may only be passing the orbit; it is watched to the last
/// sample.
class DistanceWatch {
 public:
  static constexpr double rounding_distance = 1e-9;  ///< closer than this, distances are rounding

  /// Whether sample number `sample` (from 1) is as close as required, for a motion that began at the distance `before`.
  static bool is_closer(double distance, int sample, double before) {
    constexpr double factor = 0.75;
    return distance < std::max(rounding_distance, std::pow(factor, sample) * before);
  }

  /// `slowest`: modulus of the orbit's first multiplier; `period`: period of the orbit, in forcing periods.
  DistanceWatch(double distance, double slowest, int period) : before_(distance), closer_(distance < rounding_distance) {
    constexpr double most = 20000.0;
    constexpr int not_long = 256, most_times = 8;
    const double turns = slowest > 0.0 ? std::ceil(std::log(0.5) / std::log(slowest)) : 1.0;
    periods_ = period * static_cast<int>(std::clamp(turns, 1.0, most / period));
    times_ = std::clamp(not_long / periods_, 1, most_times);
  }

  bool open() const { return !closer_ && done_ < times_; }
  int periods() const { return periods_; }  ///< between two samples
  void see(double distance) {
    constexpr double far_off = 1e-3;
    ++done_;
    const bool closer = is_closer(distance, done_, before_);
    closer_ = closer && (before_ < far_off || done_ == times_);
  }
  void stop() { done_ = times_; }
  bool comes_closer() const { return closer_; }

 private:
  double before_;
  bool closer_;
  int periods_ = 1, times_ = 1, done_ = 0;
};

}  // namespace graze
