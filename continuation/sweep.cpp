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

/// Rows that wait for their time average before those behind them are final: enough for all threads, and not too many to lose.
constexpr std::size_t most_open = 8;

/// The rows of one direction.
class OneWay {
 public:
  OneWay(const HybridSystem& system, const Vector& p, const Vector& start, const SweepOptions& options, SweepDirection direction,
         const std::vector<SweepRow>& so_far)
      : system_(system), options_(options), parameter_(parameter_index(system.parameters, options.parameter)), p_(p),
        start_(start), direction_(direction), values_(sweep_values(options.from, options.to, options.step)) {
    if (direction == SweepDirection::down) std::reverse(values_.begin(), values_.end());
    std::copy_if(so_far.begin(), so_far.end(), std::back_inserter(rows_),
                 [&](const SweepRow& row) { return row.direction == direction; });
    final_ = rows_.size();
    finding_ = options.attractor;
    finding_.lyapunov.cancelled = options.cancelled;
  }

  bool ended() const { return ended_ || final_ == values_.size(); }

  /// Follows the attractor to the end, or until enough rows wait for their average; these are `open`.
  void go_ahead() {
    open_.clear();
    while (!ended_ && rows_.size() < values_.size() && open_.size() < most_open) {
      auto row = next();
      if (!row) {
        ended_ = true;
        break;
      }
      if (row->attractor.type != AttractorType::periodic) open_.push_back(rows_.size());
      rows_.push_back(std::move(*row));
    }
  }

  std::size_t open() const { return open_.size(); }

  /// Returns the value of the row.
  double average(std::size_t k) {
    SweepRow& row = rows_[open_[k]];
    row.attractor.state = row.end;
    average_on_attractor(system_, parameters(row.value), row.attractor, finding_);
    return row.value;
  }

  /// Keeps the rows up to the first one whose average was interrupted, or turned out to end on an orbit.
  void settle() {
    for (const std::size_t k : open_) {
      SweepRow& row = rows_[k];
      const LyapunovStop stop = row.attractor.time_average.stop;
      if (stop == LyapunovStop::interrupted || stop == LyapunovStop::failed || stop == LyapunovStop::not_run) {
        rows_.resize(k);
        ended_ = true;
        break;
      }
      if (row.attractor.type != AttractorType::periodic) continue;
      sample(row);
      rows_.resize(k + 1);
      ended_ = false;
      break;
    }
    final_ = rows_.size();
  }

  std::vector<SweepRow>& rows() { return rows_; }
  double last_value() const { return rows_.empty() ? values_.front() : rows_.back().value; }

 private:
  Vector parameters(double value) const {
    Vector p = p_;
    p[static_cast<Eigen::Index>(parameter_)] = value;
    return p;
  }

  /// Empty where it was interrupted, or where the motion could not be carried on.
  std::optional<SweepRow> next() const {
    AttractorOptions finding = finding_;
    if (rows_.empty()) finding.transient = options_.first_transient;
    SweepRow row;
    row.value = values_[rows_.size()];
    row.direction = direction_;
    try {
      row.attractor = approach_attractor(system_, parameters(row.value), rows_.empty() ? start_ : rows_.back().end, finding);
    } catch (const std::invalid_argument&) {  // the state before lies inside the barrier of this value
      return std::nullopt;
    }
    if (row.attractor.termination != Termination::time || (options_.cancelled && options_.cancelled())) return std::nullopt;
    if (row.attractor.type == AttractorType::periodic)
      average_on_attractor(system_, parameters(row.value), row.attractor, finding_);
    sample(row);
    return row;
  }

  void sample(SweepRow& row) const {
    const Vector p = parameters(row.value);
    Propagator propagator(system_, p, {}, options_.attractor.lyapunov.flow);
    const double T = forcing_period(system_, p);
    Transition transition;
    Vector x = row.attractor.state;
    row.states.clear();
    row.impact_speeds.clear();
    const int count = row.attractor.type == AttractorType::periodic ? row.attractor.period : options_.samples;
    for (int k = 0; k < count; ++k) {
      row.states.push_back(x);
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none, .keep_events = true}, transition);
      if (transition.termination != Termination::time) break;
      for (const EventRecord& event : transition.events)
        if (begins_contact(event.kind)) row.impact_speeds.push_back(event.normal_speed);
      x = transition.x1;
    }
    row.end = x;
  }

  const HybridSystem& system_;
  const SweepOptions& options_;
  AttractorOptions finding_;
  std::size_t parameter_;
  Vector p_, start_;
  SweepDirection direction_;
  std::vector<double> values_;
  std::vector<SweepRow> rows_;
  std::vector<std::size_t> open_;
  std::size_t final_ = 0;
  bool ended_ = false;
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
  std::vector<OneWay> ways;
  for (const SweepDirection direction : options.directions) ways.emplace_back(system, p, start, options, direction, so_far);
  oneapi::tbb::task_arena arena(std::max(1, options.threads));
  const auto together = [&](std::size_t count, const auto& body) {
    arena.execute([&] { oneapi::tbb::parallel_for(std::size_t{0}, count, body, oneapi::tbb::simple_partitioner()); });
  };
  while (!std::all_of(ways.begin(), ways.end(), [](const OneWay& way) { return way.ended(); })) {
    together(ways.size(), [&](std::size_t d) { ways[d].go_ahead(); });
    std::vector<std::pair<std::size_t, std::size_t>> open;
    for (std::size_t d = 0; d < ways.size(); ++d)
      for (std::size_t k = 0; k < ways[d].open(); ++k) open.emplace_back(d, k);
    std::size_t done = 0;
    for (OneWay& way : ways) done += way.rows().size();
    done -= open.size();
    std::mutex telling;
    const auto tell = [&](std::size_t more, double value) {
      const std::lock_guard lock(telling);
      done += more;
      if (options.progress) options.progress(done, value);
    };
    if (open.empty() && done > 0) tell(0, ways.front().last_value());
    together(open.size(), [&](std::size_t i) { tell(1, ways[open[i].first].average(open[i].second)); });
    for (OneWay& way : ways) way.settle();
  }
  std::vector<SweepRow> all;
  for (OneWay& way : ways) std::move(way.rows().begin(), way.rows().end(), std::back_inserter(all));
  return all;
}

}  // namespace graze
