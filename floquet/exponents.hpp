// SPDX-License-Identifier: GPL-3.0-or-later
// Exponents: what time averages have come to, direction by direction, while they are taken (lyapunov.cpp along one motion,
// lyapunov_lanes.cpp along many): whether that is enough, and how they are handed over.
#pragma once

#include <graze/floquet/batch_means.hpp>
#include <graze/floquet/lyapunov.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace graze {

/// Whether precise_enough is to be asked: standard errors are what ends the average, and there are others than before. `lost`:
/// the first direction is; `first`: its means.
inline bool has_new_errors(const LyapunovOptions& options, bool lost, const BatchMeans& first) {
  return options.change == 0.0 && options.standard_error > 0.0 && (lost || first.ended_batch());
}

/// Whether LyapunovOptions' bounds are met after so many periods. `exponent(i)` is -infinity of a direction that is lost, whose
/// `error(i)` is 0.
template <class Exponent, class Error>
bool precise_enough(const LyapunovOptions& options, std::int64_t periods, std::size_t directions, const Exponent& exponent,
                    const Error& error) {
  if (periods < options.min_periods || std::abs(exponent(0)) < options.significance * error(0)) return false;
  for (std::size_t i = 0; i < directions; ++i)
    if (!(error(i) < options.standard_error)) return false;
  return true;
}

/// Puts exponents, errors and correlation times in order, largest exponent first, and the dimension with them.
template <class Exponent, class Error, class Correlation>
void hand_over(std::size_t directions, const Exponent& exponent, const Error& error, const Correlation& correlation,
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
