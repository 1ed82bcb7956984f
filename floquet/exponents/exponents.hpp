// SPDX-License-Identifier: GPL-3.0-or-later
// What the numbers of a running average (running_average.hpp) say: the error of a mean whose series has a trend, and whether its
// tangents grow as in chaos.
#pragma once

#include <cmath>
#include <cstdint>

namespace graze {

/// Standard errors by which the two halves of a series must differ to count as a trend: by chance once in 16000.
inline constexpr double trend_significance = 4.0;

/// Standard error of a mean, including the trend of its series; `drift` is that of BatchMeans. Each half has sqrt 2 times the
/// error of the whole series, and their difference twice that error. Batch means alone take a decaying series (of order
/// ln N / N) for a constant one.
inline double with_trend(double error, double drift) {
  return std::abs(drift) > 2.0 * trend_significance * error ? std::hypot(error, 0.5 * drift) : error;
}

/// Whether a tangent has grown as in chaos; `log_growth` and `log_volume` are sums over `periods`. If volumes shrink, the mean
/// growth decides, and this returns true. If they do not, tangents of ordered motions grow too: shear makes them grow in
/// proportion to time.
inline bool grows_beyond_shear(double log_growth, double log_volume, std::int64_t periods) {
  constexpr double shrinks = 1.0;        // in ln(volume); below, contraction does not show yet
  constexpr double largest_shear = 1e4;  // per forcing period
  return std::abs(log_volume) > shrinks || log_growth > std::log(largest_shear * static_cast<double>(periods));
}

}  // namespace graze
