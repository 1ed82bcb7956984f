// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <fmt/format.h>

#include <cmath>
#include <limits>
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
  constexpr std::int64_t to_the_end = std::numeric_limits<std::int64_t>::max();
  constexpr std::size_t most_at_once = 256;
  validate(options);
  LyapunovSpectrum out;
  const auto average = [&](std::size_t, TaskSlot& slot) -> MotionTask<> {
    slot.set_parameters(p, options.motions == 1);  // one motion gains nothing from lanes
    const AverageStart start{p, state};
    RunningAverage running(slot, start, options);
    co_await running.carry(slot, to_the_end, most_at_once);
    out = std::move(running).result();
  };
  run_tasks(system, options.flow, options.all_threads, 1, average);
  return out;
}

}  // namespace graze
