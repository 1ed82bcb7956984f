// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/follow/sweep_work.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze {

std::string_view sweep_direction_name(SweepDirection direction) { return direction == SweepDirection::up ? "up" : "down"; }

std::vector<double> sweep_values(double from, double to, double step) {
  if (!(from < to) || !(step > 0.0) || !std::isfinite(to - from))
    throw std::invalid_argument(
        fmt::format("a sweep goes from {} to {} by {}; it needs from < to and a step > 0", from, to, step));
  const double count = std::floor((to - from) / step * (1.0 + 1e-12));
  if (count > 1e6)
    throw std::invalid_argument(fmt::format("a sweep by {} has {:.3g} values; at most a million are allowed", step, count));
  std::vector<double> values;
  for (int k = 0; k <= static_cast<int>(count); ++k) values.push_back(from + k * step);
  return values;
}

std::vector<SweepRow> sweep(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options,
                            const std::vector<SweepRow>& so_far) {
  SweepWork sweep(system, p, start, options, so_far);
  oneapi::tbb::task_arena arena(std::max(1, options.threads));
  arena.execute([&] { in_parallel(available_threads(), [&](std::size_t) { sweep.work(); }); });
  return std::move(sweep).rows();
}

}  // namespace graze
