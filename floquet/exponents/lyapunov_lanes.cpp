// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/averaged_motion.hpp>
#include <graze/floquet/exponents/exponents.hpp>
#include <graze/floquet/exponents/frame_average.hpp>
#include <graze/floquet/exponents/lyapunov_lanes.hpp>
#include <graze/lib/numerics/parallel.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace graze {

namespace {

/// An average that may stop early is expected to be long once it has reached this many periods.
constexpr std::int64_t lasting = LaneCarrier::periods_for_table / 4;
/// Forcing periods between two tests of the stop rule: an eighth of those so far, so that few are carried in vain.
constexpr std::size_t shortest_stretch = 32, longest_stretch = 256;
/// Last part of `parting`, with a tangent, to align it: chaos aligns tangent vectors sooner than it separates motions.
constexpr std::int64_t aligning_periods = 60;
/// Periods per motion from which the use of all threads pays.
constexpr std::size_t long_for_threads = 64;

/// One average over all motions of one start.
class Average {
 public:
  Average(const AverageStart& start, std::size_t set, const LyapunovOptions& options, double period)
      : options_(options), interval_time_(options.interval * period) {
    for (const MotionStart& one : neighbouring_starts(set, start.state, std::max(1, options.motions))) motions_.emplace_back(one);
    uncounted_ = std::max<std::int64_t>(options.aligning, motions_.size() > 1 ? aligning_periods : 0);
    to_part_ = motions_.size() > 1 ? std::max<std::int64_t>(0, decorrelation_periods - uncounted_) : 0;
    out_.stop = LyapunovStop::budget;
    out_.state = start.state;
    open_ = options.max_periods >= options.interval * static_cast<std::int64_t>(motions_.size());
  }

  bool open() const { return open_; }
  /// Writes the present states of the motions.
  void ask(std::vector<MotionStart>& motions) const {
    motions.clear();
    for (const AveragedMotion& motion : motions_) motions.push_back(motion.at());
  }

  /// Tells `many` how many periods will follow, once that is known.
  void announce(LaneCarrier& many, std::size_t parameters) {
    const bool to_the_end = options_.standard_error == 0.0 && options_.change == 0.0;
    if (announced_ || (!to_the_end && out_.periods < lasting)) return;
    announced_ = true;
    many.expect(parameters, options_.max_periods - out_.periods);
  }

  /// The next work: whether with tangents, and how many of `periods` periods.
  bool with_tangents() const { return to_part_ == 0; }
  std::size_t part_of(std::size_t periods) const {
    return with_tangents() ? periods : std::min(periods, static_cast<std::size_t>(to_part_));
  }

  /// Adds the results of `periods` more periods of each motion, motion by motion.
  void add(const PeriodResult* results, std::size_t periods, std::size_t threads) {
    if (!with_tangents()) return part(results, periods);
    for (std::size_t k = 0; k < periods && open_;) {
      const std::size_t n = std::min<std::size_t>(periods - k, static_cast<std::size_t>(until_look()));
      const bool counted = uncounted_ == 0;
      const std::size_t parts = n >= long_for_threads ? std::min(threads, motions_.size()) : 1;
      in_parallel(parts, [&](std::size_t part) {
        for (std::size_t i = part * motions_.size() / parts; i < (part + 1) * motions_.size() / parts; ++i)
          motions_[i].add({&results[i * periods + k], n}, counted, options_.interval);
      });
      k += n;
      if (gather(); out_.termination != Termination::time) {
        stop(LyapunovStop::failed);
      } else if (!counted) {
        uncounted_ -= static_cast<std::int64_t>(n);
      } else if (motions_.front().periods_open() == 0) {
        look();
      }
    }
    out_.state = first_state();
  }

  void stop(LyapunovStop reason) {
    if (open_) out_.stop = reason;
    open_ = false;
  }
  std::int64_t periods() const { return out_.periods; }
  const Vector& state() const { return out_.state; }
  bool cancelled() const { return options_.cancelled && options_.cancelled(); }

  LyapunovSpectrum result() && {
    const auto correlation = [&](std::size_t i) {
      double time = 0.0;
      for (const AveragedMotion& motion : motions_) time += motion.means(i).correlation_time();
      return lost_[i] ? 0.0 : time / static_cast<double>(motions_.size()) * options_.interval;
    };
    write_exponents(
        2, [&](std::size_t i) { return exponent(i); }, [&](std::size_t i) { return standard_error(i); }, correlation, out_);
    for (std::size_t i = 1; i < motions_.size(); ++i) out_.others.push_back(Vector{{motions_[i].at().x, motions_[i].at().v}});
    return std::move(out_);
  }

 private:
  /// Periods until the next test: the motions begin to count, have a new standard error, or may end.
  std::int64_t until_look() const {
    if (uncounted_ > 0) return uncounted_;
    const AveragedMotion& first = motions_.front();
    const std::int64_t all = static_cast<std::int64_t>(motions_.size()), to_end = (options_.max_periods - out_.periods) / all;
    const std::int64_t intervals = options_.change > 0.0 || lost_[0] ? 1 : first.means(0).until_batch_ends();
    return std::max<std::int64_t>(1, std::min(intervals * options_.interval - first.periods_open(), to_end));
  }

  void part(const PeriodResult* results, std::size_t periods) {
    for (std::size_t i = 0; i < motions_.size(); ++i) motions_[i].pass({&results[i * periods], periods});
    to_part_ -= static_cast<std::int64_t>(periods);
    if (gather(); out_.termination != Termination::time) stop(LyapunovStop::failed);
    out_.state = first_state();
  }

  Vector first_state() const { return Vector{{motions_.front().at().x, motions_.front().at().v}}; }

  /// Collects the sums over all motions.
  void gather() {
    out_.impacts = 0;
    out_.periods = 0;
    out_.log_growth = out_.log_volume = 0.0;
    out_.termination = Termination::time;
    for (const AveragedMotion& motion : motions_) {
      out_.impacts += motion.impacts();
      out_.periods += motion.averaged();
      out_.log_growth += motion.means(0).total() / static_cast<double>(motions_.size());
      out_.log_volume += motion.log_volume() / static_cast<double>(motions_.size());
      out_.liouville_residual = std::max(out_.liouville_residual, motion.liouville_residual());
      for (std::size_t i = 0; i < 2; ++i) lost_[i] = lost_[i] || motion.lost(i);
      if (motion.termination() != Termination::time) out_.termination = motion.termination();
    }
  }

  /// Applies the stop rule after an orthonormalisation of all motions.
  void look() {
    const std::int64_t round = options_.interval * static_cast<std::int64_t>(motions_.size());
    if (options_.change > 0.0) {
      const std::array<double, 2> before = last_;
      for (std::size_t i = 0; i < 2; ++i) last_[i] = lost_[i] ? 0.0 : exponent(i);
      const double change = std::max(std::abs(last_[0] - before[0]), std::abs(last_[1] - before[1]));
      if (out_.periods > round && change < options_.change) return stop(LyapunovStop::change);
    }
    if (has_new_errors(options_, lost_[0], motions_.front().means(0)) && settled()) return stop(LyapunovStop::standard_error);
    if (out_.periods + round > options_.max_periods) open_ = false;
  }

  bool settled() const {
    const std::int64_t each = out_.periods / static_cast<std::int64_t>(motions_.size());
    const bool is_chaos = grows_beyond_shear(out_.log_growth, out_.log_volume, each);
    return precise_enough(
        options_, out_.periods, is_chaos, 2, [&](std::size_t i) { return exponent(i); },
        [&](std::size_t i) { return standard_error(i); });
  }

  double exponent(std::size_t i) const {
    if (lost_[i]) return -std::numeric_limits<double>::infinity();
    double sum = 0.0;
    std::int64_t count = 0;
    for (const AveragedMotion& motion : motions_) {
      sum += motion.means(i).total();
      count += motion.means(i).count();
    }
    return sum / static_cast<double>(std::max<std::int64_t>(count, 1)) / interval_time_;
  }
  /// The motions are independent, except for the ends of their series: near an orbit they do not separate. If they differ by
  /// more than their own errors explain (some have settled, or their correlation lasts longer than the average), their spread
  /// gives the error.
  double standard_error(std::size_t i) const {
    if (lost_[i]) return 0.0;
    const auto n = static_cast<double>(motions_.size());
    double squares = 0.0, edges = 0.0, mean = 0.0, apart = 0.0, drift = 0.0;
    for (const AveragedMotion& motion : motions_) {
      squares += motion.means(i).standard_error() * motion.means(i).standard_error();
      edges += motion.means(i).edge() / n;
      mean += motion.means(i).mean() / n;
      drift += motion.means(i).drift() / n;
    }
    for (const AveragedMotion& motion : motions_) apart += (motion.means(i).mean() - mean) * (motion.means(i).mean() - mean);
    const double spread = motions_.size() > 1 ? apart / (n - 1.0) / n : 0.0;
    return with_trend(std::sqrt(std::max(squares / (n * n), spread) + edges * edges), drift) / interval_time_;
  }

  const LyapunovOptions& options_;
  double interval_time_;
  std::vector<AveragedMotion> motions_;
  std::int64_t to_part_ = 0, uncounted_ = 0;
  std::array<bool, 2> lost_{};
  std::array<double, 2> last_{};
  bool open_ = true, announced_ = false;
  LyapunovSpectrum out_;
};

}  // namespace

std::vector<MotionStart> neighbouring_starts(std::size_t parameters, const Vector& state, int motions) {
  std::vector<MotionStart> starts;
  const double apart = 1e-7 * (1.0 + std::abs(state[0]));
  for (int i = 0; i < motions; ++i) starts.push_back({parameters, state[0] - apart * i, state[1]});
  return starts;
}

class RunningAverage::Motions : public Average {
  using Average::Average;
};

RunningAverage::RunningAverage(const TaskSlot& lane, const HybridSystem& system, const AverageStart& start,
                               const LyapunovOptions& options) {
  if (!lane.in_lanes()) {
    alone_ = std::make_unique<FrameAverage>(system, start, options);
    return;
  }
  validate(options);
  initial_mode(system, 0.0, start.state, start.p);
  in_lanes_ = std::make_unique<Motions>(start, lane.parameters(), options, forcing_period(system, start.p));
}

RunningAverage::~RunningAverage() = default;

MotionTask<bool> RunningAverage::carry(TaskSlot& lane, std::int64_t periods) {
  if (alone_) {
    while (alone_->open() && alone_->periods() < periods) alone_->carry_interval();
    co_return alone_->open();
  }
  Motions& average = *in_lanes_;
  std::vector<MotionStart> next;
  while (average.open() && average.periods() < periods) {
    if (average.cancelled()) {
      average.stop(LyapunovStop::interrupted);
      break;
    }
    average.announce(lane.motions(), lane.parameters());
    average.ask(next);
    const std::size_t stretch = average.part_of(shortest_stretch);
    const std::span<const PeriodResult> carried = co_await lane.carry(next, stretch, average.with_tangents());
    average.add(carried.data(), stretch, 1);
  }
  co_return average.open();
}

const Vector& RunningAverage::state() const { return alone_ ? alone_->state() : in_lanes_->state(); }

LyapunovSpectrum RunningAverage::result() && { return alone_ ? std::move(*alone_).result() : std::move(*in_lanes_).result(); }

LyapunovSpectrum lane_spectrum(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options) {
  validate(options);
  initial_mode(system, 0.0, start.state, start.p);
  LaneCarrier many(system, options.flow);
  if (options.all_threads) many.use_all_threads();
  const std::size_t threads = options.all_threads ? available_threads() : 1;
  const std::size_t set = many.add_parameters(start.p);
  if (options.table) many.use(set, *options.table);
  Average average(start, set, options, forcing_period(system, start.p));
  std::vector<MotionStart> motions;
  std::vector<PeriodResult> results;
  std::int64_t told = 0;
  for (std::size_t carried = 0; average.open();) {
    if (average.cancelled()) {
      average.stop(LyapunovStop::interrupted);
      break;
    }
    average.announce(many, set);
    average.ask(motions);
    const std::size_t stretch = average.part_of(std::clamp(carried / 8, shortest_stretch, longest_stretch));
    many.carry(motions, stretch, average.with_tangents(), results);
    carried += stretch;
    average.add(results.data(), stretch, threads);
    if (options.progress && average.periods() > told) options.progress(told = average.periods());
  }
  return std::move(average).result();
}

}  // namespace graze
