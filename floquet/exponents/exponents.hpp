// SPDX-License-Identifier: GPL-3.0-or-later
// Evaluation of running time averages (average.hpp), direction by direction: whether they are precise enough, and how they are
// written to the result.
#pragma once

#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/lib/numerics/batch_means.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

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

/// Whether precise_enough must be evaluated: the standard errors end the average, and they have changed. `lost`: the first
/// direction is lost; `first`: its means.
inline bool has_new_errors(const LyapunovOptions& options, bool lost, const BatchMeans& first) {
  return options.change == 0.0 && options.standard_error > 0.0 && (lost || first.ended_batch());
}

/// Whether the bounds of LyapunovOptions are met after `periods`; `is_chaos` is the result of grows_beyond_shear. For a lost
/// direction `exponent(i)` is -infinity and `error(i)` is 0.
template <class Exponent, class Error>
bool precise_enough(const LyapunovOptions& options, std::int64_t periods, bool is_chaos, std::size_t directions,
                    const Exponent& exponent, const Error& error) {
  if (options.significance > 0.0 && !is_chaos) return false;
  if (periods < options.min_periods || std::abs(exponent(0)) < options.significance * error(0)) return false;
  for (std::size_t i = 0; i < directions; ++i)
    if (!(error(i) < options.standard_error)) return false;
  return true;
}

/// Writes exponents, errors and correlation times to `out`, largest exponent first, and the dimension.
template <class Exponent, class Error, class Correlation>
void write_exponents(std::size_t directions, const Exponent& exponent, const Error& error, const Correlation& correlation,
                     LyapunovSpectrum& out) {
  std::vector<std::size_t> order(directions);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return exponent(a) > exponent(b); });
  for (const std::size_t i : order) {
    out.exponents.push_back(exponent(i));
    out.standard_errors.push_back(error(i));
    out.correlation_times.push_back(correlation(i));
  }
  out.kaplan_yorke = kaplan_yorke_dimension(out.exponents);
}

}  // namespace graze
