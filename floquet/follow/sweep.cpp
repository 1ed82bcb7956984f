// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/floquet/follow/row_runner.hpp>
#include <graze/floquet/follow/sweep_chain.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace graze {

namespace {

/// Chaos found by an average over fewer forcing periods must be confirmed by a second one.
constexpr std::int64_t short_average = 500;

SweepOptions with_looks(SweepOptions options) {
  options.attractor.recurrence = usual_recurrence;
  options.attractor.confirmed_below = short_average;
  LyapunovOptions& averaging = options.attractor.lyapunov;
  averaging.aligning = std::max(averaging.aligning, aligning_periods);
  averaging.motions = std::max(averaging.motions, motions_in_company(averaging));
  return options;
}

/// One direction of a sweep.
struct Direction {
  SweepDirection direction;
  std::vector<SweepRow> rows = {};  ///< the first ones, which nothing can change any more
  std::shared_ptr<Row> work = {};
};

}  // namespace

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
  const SweepOptions looking = with_looks(options);
  oneapi::tbb::task_arena arena(std::max(1, options.threads));
  const std::size_t threads = arena.execute([] { return available_threads(); });
  std::vector<Direction> directions;
  for (const SweepDirection direction : options.directions) directions.push_back({direction});
  const auto all_rows = [&directions] {
    std::vector<SweepRow> all;
    for (const Direction& direction : directions) all.insert(all.end(), direction.rows.begin(), direction.rows.end());
    return all;
  };
  RowRunnerOptions running;
  running.flow = looking.attractor.lyapunov.flow;
  running.threads = threads;
  running.enough = running.most =
      std::max<std::size_t>(1, running.enough / static_cast<std::size_t>(looking.attractor.lyapunov.motions));
  running.cancelled = options.cancelled;
  RowRunner runner(system, running);
  std::vector<std::shared_ptr<Row>> rows;
  for (Direction& direction : directions) {
    auto chain = std::make_unique<SweepChain>(system, p, start, looking, direction.direction);
    std::vector<RowPoint> known;
    for (const SweepRow& row : so_far)
      if (row.direction == direction.direction) {
        direction.rows.push_back(row);
        static_cast<FollowedAttractor&>(known.emplace_back()) = row;
      }
    Row::Listener listener;
    listener.commit = [&direction, chain = chain.get()](std::size_t number, const RowPoint& point) {
      SweepRow& row = direction.rows.emplace_back();
      static_cast<FollowedAttractor&>(row) = point;
      row.value = chain->value(number);
      row.direction = direction.direction;
    };
    listener.done = [&, chain = chain.get()](std::size_t number) {
      std::size_t done = 0;
      for (const Direction& one : directions) done += one.work->done();
      if (options.progress) options.progress(done, chain->value(number));
      if (options.keep) options.keep(all_rows);
    };
    direction.work = std::make_shared<Row>(std::move(chain), listener, Row::usual_guesses(threads), std::move(known));
    rows.push_back(direction.work);
  }
  runner.give(rows);
  runner.close();
  arena.execute([&] { in_parallel(threads, [&](std::size_t) { runner.work(); }); });
  return all_rows();
}

}  // namespace graze
