// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/sweep.hpp>

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>

namespace graze {

namespace {

class OneWay {
 public:
  OneWay(const HybridSystem& system, const SweepOptions& options, std::size_t parameter)
      : system_(system), options_(options), parameter_(static_cast<Eigen::Index>(parameter)) {}

  /// Empty where it was interrupted, or where the motion could not be carried on.
  std::optional<SweepRow> row(Vector p, double value, SweepDirection direction, const Vector& start, bool first) const {
    p[parameter_] = value;
    AttractorOptions finding = options_.attractor;
    finding.lyapunov.cancelled = options_.cancelled;
    if (first) finding.transient = options_.first_transient;
    SweepRow row;
    row.value = value;
    row.direction = direction;
    try {
      row.attractor = find_attractor(system_, p, start, finding);
    } catch (const std::invalid_argument&) {  // the state before lies inside the barrier of this value
      return std::nullopt;
    }
    if (row.attractor.termination != Termination::time || (options_.cancelled && options_.cancelled())) return std::nullopt;
    sample(p, row);
    return row;
  }

 private:
  void sample(const Vector& p, SweepRow& row) const {
    Propagator propagator(system_, p, {}, options_.attractor.lyapunov.flow);
    const double T = forcing_period(system_, p);
    Transition transition;
    Vector x = row.attractor.state;
    const int count = row.attractor.type == AttractorType::periodic ? row.attractor.period : options_.samples;
    for (int k = 0; k < count; ++k) {
      row.states.push_back(x);
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none, .keep_events = true}, transition);
      if (transition.termination != Termination::time) break;
      for (const EventRecord& event : transition.events)
        if (event.kind == EventKind::impact || event.kind == EventKind::enter) row.impact_speeds.push_back(event.normal_speed);
      x = transition.x1;
    }
    row.end = x;
  }

  const HybridSystem& system_;
  const SweepOptions& options_;
  Eigen::Index parameter_;
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
  const std::size_t parameter = parameter_index(system.parameters, options.parameter);
  const std::vector<double> ascending = sweep_values(options.from, options.to, options.step);
  const OneWay way(system, options, parameter);
  std::vector<std::vector<SweepRow>> rows(options.directions.size());
  std::mutex telling;
  std::size_t done = 0;
  oneapi::tbb::task_arena arena(std::max(1, options.threads));
  arena.execute([&] {
    oneapi::tbb::parallel_for(std::size_t{0}, options.directions.size(), [&](std::size_t d) {
      const SweepDirection direction = options.directions[d];
      std::copy_if(so_far.begin(), so_far.end(), std::back_inserter(rows[d]),
                   [&](const SweepRow& row) { return row.direction == direction; });
      for (std::size_t k = rows[d].size(); k < ascending.size(); ++k) {
        const double value = direction == SweepDirection::up ? ascending[k] : ascending[ascending.size() - 1 - k];
        auto row = way.row(p, value, direction, rows[d].empty() ? start : rows[d].back().end, rows[d].empty());
        if (!row) return;
        rows[d].push_back(std::move(*row));
        const std::lock_guard lock(telling);
        ++done;
        if (options.progress) options.progress(done, value);
      }
    });
  });
  std::vector<SweepRow> all;
  for (auto& list : rows) std::move(list.begin(), list.end(), std::back_inserter(all));
  return all;
}

}  // namespace graze
