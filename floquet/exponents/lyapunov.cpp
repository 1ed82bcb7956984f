// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/lib/motion/lane_carrier.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace graze {

void validate(const LyapunovOptions& options) {
  if (options.interval < 1)
    throw std::invalid_argument(fmt::format("interval is {}; allowed is a whole number >= 1", options.interval));
  if (options.motions < 1)
    throw std::invalid_argument(fmt::format("motions is {}; allowed is a whole number >= 1", options.motions));
  if (options.aligning < 0)
    throw std::invalid_argument(fmt::format("aligning is {}; allowed is a whole number >= 0", options.aligning));
  if (options.max_periods < options.interval)
    throw std::invalid_argument(
        fmt::format("max_periods is {}; allowed is at least the interval, {}", options.max_periods, options.interval));
  if (!(options.standard_error >= 0.0) || !(options.change >= 0.0) || !(options.significance >= 0.0))
    throw std::invalid_argument("the bounds of standard error, significance and change must be >= 0");
}

std::string_view lyapunov_stop_text(LyapunovStop reason) {
  switch (reason) {
  case LyapunovStop::not_run:
    return "it was not run";
  case LyapunovStop::standard_error:
    return "every standard error is below its bound";
  case LyapunovStop::change:
    return "the exponents changed by less than the bound from one orthonormalisation to the next";
  case LyapunovStop::budget:
    return "the budget of forcing periods is used up";
  case LyapunovStop::interrupted:
    return "it was interrupted";
  case LyapunovStop::failed:
    return "the motion could not be carried on";
  }
  return "";
}

std::string_view lyapunov_stop_text(const LyapunovSpectrum& average) {
  const bool counts_returns = average.duration > 0.0;
  if (counts_returns && average.stop == LyapunovStop::budget) return "the budget of returns is used up";
  return lyapunov_stop_text(average.stop);
}

double period_time(const HybridSystem& system, const Vector& p, const LyapunovSpectrum& average) {
  return is_forced(system) ? forcing_period(system, p) : average.duration / static_cast<double>(average.periods);
}

double kaplan_yorke_dimension(const std::vector<double>& exponents) {
  double sum = 0.0;
  for (std::size_t j = 0; j < exponents.size(); ++j) {
    if (sum + exponents[j] < 0.0) return static_cast<double>(j) + (std::isfinite(exponents[j]) ? sum / -exponents[j] : 0.0);
    sum += exponents[j];
  }
  return static_cast<double>(exponents.size());
}

LyapunovSpectrum lyapunov_spectrum(const HybridSystem& system, const Vector& p, const Vector& state,
                                   const LyapunovOptions& options) {
  if (options.motions > 1)
    if (const std::unique_ptr<LaneCarrier> many = make_lane_carrier(system, {&p, 1}, options.flow))
      return lane_spectrum(*many, state, options);
  return frame_spectrum(system, {p, state}, options);
}

}  // namespace graze
