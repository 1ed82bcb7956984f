// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/average.hpp>
#include <graze/floquet/exponents/lane_motion.hpp>
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/lib/numerics/parallel.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace graze {

namespace {

/// An average that may stop early is expected to be long once it has reached this many periods.
constexpr std::int64_t lasting = LaneCarrier::periods_for_table / 4;
/// Forcing periods between two tests of the stop rule: an eighth of those so far, so that few more are carried than needed.
constexpr std::size_t shortest_stretch = 32, longest_stretch = 256;
/// Periods per motion from which the use of all threads pays.
constexpr std::size_t long_for_threads = 64;
/// Periods that a Propagator carries at once, if there are several motions: few enough for a prompt end, and many enough to give
/// each thread some work.
constexpr std::size_t shortest_alone = 8;

/// All motions of an average in lanes.
class LaneMotions : public Average<LaneMotion> {
 public:
  LaneMotions(const AverageStart& start, std::size_t set, const LyapunovOptions& options, double period)
      : Average(motions_from(start, set, options), 2, options, period) {}

  /// Writes the present states of the motions.
  void ask(std::vector<MotionStart>& next) const {
    next.clear();
    for (const LaneMotion& motion : motions()) next.push_back(motion.at());
  }

  /// Tells `many` how many periods will follow, once that is known.
  void announce(LaneCarrier& many, std::size_t parameters) {
    const bool to_the_end = options().standard_error == 0.0 && options().change == 0.0;
    if (announced_ || (!to_the_end && periods() < lasting)) return;
    announced_ = true;
    many.expect(parameters, options().max_periods - periods());
  }

  /// Adds the results of `periods` more periods of each motion, motion by motion.
  void take(const PeriodResult* results, std::size_t periods, std::size_t threads) {
    const bool tangents = with_tangents();
    add(periods, [&](std::vector<LaneMotion>& all, std::size_t begin, std::size_t count, bool counted) {
      const std::size_t parts = count >= long_for_threads ? std::min(threads, all.size()) : 1;
      in_parallel(parts, [&](std::size_t part) {
        for (std::size_t i = part * all.size() / parts; i < (part + 1) * all.size() / parts; ++i) {
          const std::span<const PeriodResult> next(&results[i * periods + begin], count);
          tangents ? all[i].add(next, counted, options().interval) : all[i].pass(next);
        }
      });
    });
  }

 private:
  static std::vector<LaneMotion> motions_from(const AverageStart& start, std::size_t set, const LyapunovOptions& options) {
    std::vector<LaneMotion> motions;
    for (const MotionStart& one : neighbouring_starts(set, start.state, options.motions)) motions.emplace_back(one);
    return motions;
  }

  bool announced_ = false;
};

/// All motions of an average by Propagators.
class FrameMotions : public Average<FrameMotion> {
 public:
  FrameMotions(const SharedSystem& system, const AverageStart& start, const LyapunovOptions& options, int motions)
      : Average(motions_from(system, start, options, motions), system->states, options,
                is_forced(system) ? forcing_period(system, start.p) : 0.0),
        interval_(options.interval), threads_(options.all_threads ? available_threads() : 1) {}

  /// Carries all motions over some more periods.
  void carry_on() {
    const bool tangents = with_tangents();
    const auto kind = [&](bool counted) {
      if (!tangents) return FrameMotion::Kind::parting;
      return counted ? FrameMotion::Kind::counted : FrameMotion::Kind::aligning;
    };
    add(part_of(motions().size() > 1 ? shortest_alone : 1),
        [&](std::vector<FrameMotion>& all, std::size_t, std::size_t count, bool counted) {
          const std::size_t parts = std::min(threads_, all.size());
          in_parallel(parts, [&](std::size_t part) {
            for (std::size_t i = part * all.size() / parts; i < (part + 1) * all.size() / parts; ++i)
              all[i].carry(count, kind(counted), interval_);
          });
        });
  }

 private:
  static std::vector<FrameMotion> motions_from(const SharedSystem& system, const AverageStart& start,
                                               const LyapunovOptions& options, int motions) {
    std::vector<FrameMotion> all;
    for (int i = 0; i < motions; ++i) all.emplace_back(system, AverageStart{start.p, neighbour(system, start, i)}, options.flow);
    return all;
  }

  /// The start of motion i: its first coordinate that may be moved differs by i steps of 1e-7 (1 + |x|).
  static Vector neighbour(const HybridSystem& system, const AverageStart& start, int i) {
    if (i == 0) return start.state;
    for (Eigen::Index k = 0; k < start.state.size(); ++k)
      for (const double side : {-1e-7, 1e-7}) {
        Vector moved = start.state;
        moved[k] += side * i * (1.0 + std::abs(moved[k]));
        if (mode_at(system, 0.0, moved, start.p)) return moved;
      }
    return start.state;
  }

  int interval_;
  std::size_t threads_;
};

/// Shortest length of a motion in an average over several: the periods in which they separate do not count and are a small part.
constexpr std::int64_t shortest_motion = 10 * decorrelation_periods;

/// Number of chaotic motions averaged in parallel. It fills the lanes of one thread, provided that most of each motion's budget
/// remains after parting. It grows up to the lanes of several threads if each motion lasts for at least `shortest_motion`.
constexpr std::int64_t motions_of_a_thread = 16, most_motions = 128;
constexpr std::int64_t budget_for_many = 4 * motions_of_a_thread * decorrelation_periods;

/// Expected length of an average: its budget, or the periods after which the standard error reaches its bound. (The growth per
/// period has a standard deviation of about 1/3, and a period is about 2 pi long.)
std::int64_t expected_periods(const LyapunovOptions& averaging) {
  const double per_error = 3.0 * averaging.standard_error * 2.0 * std::numbers::pi;
  return static_cast<std::int64_t>(
      std::min(static_cast<double>(averaging.max_periods), per_error > 0.0 ? 1.0 / (per_error * per_error) : 1e18));
}

/// Motions of an average that has the lanes for itself.
int motions_in_lanes(const LyapunovOptions& averaging) {
  if (averaging.change > 0.0 || averaging.max_periods < budget_for_many) return 1;
  const std::int64_t wanted = expected_periods(averaging) / shortest_motion;
  return static_cast<int>(std::clamp(wanted / motions_of_a_thread * motions_of_a_thread, motions_of_a_thread, most_motions));
}

/// Motions of an average by Propagators: several threads share them. Their number depends on the length alone, so that the result
/// does not depend on the machine.
int motions_of_propagators(const LyapunovOptions& averaging) {
  constexpr std::int64_t step = 4, most = 32;
  const std::int64_t wanted = expected_periods(averaging) / shortest_motion;
  if (averaging.change > 0.0 || wanted < step) return 1;
  return static_cast<int>(std::min(wanted / step * step, most));
}

}  // namespace

int enough_motions(const HybridSystem& system, const Vector& p, const LyapunovOptions& averaging) {
  return motions_at_once(system, p, averaging.flow) > 1 ? motions_in_lanes(averaging) : motions_of_propagators(averaging);
}

int motions_in_shared_lanes(const LyapunovOptions& averaging) {
  const int alone = motions_in_lanes(averaging);
  return expected_periods(averaging) < 4 * decorrelation_periods * alone ? 1 : alone;
}

std::vector<MotionStart> neighbouring_starts(std::size_t parameters, const Vector& state, int motions) {
  std::vector<MotionStart> starts;
  const double apart = 1e-7 * (1.0 + std::abs(state[0]));
  for (int i = 0; i < motions; ++i) starts.push_back({parameters, state[0] - apart * i, state[1]});
  return starts;
}

class RunningAverage::InLanes : public LaneMotions {
  using LaneMotions::LaneMotions;
};
class RunningAverage::Alone : public FrameMotions {
  using FrameMotions::FrameMotions;
};

RunningAverage::RunningAverage(const TaskSlot& lane, const HybridSystem& system, const AverageStart& start,
                               const LyapunovOptions& options) {
  validate(options);
  if (!lane.in_lanes()) {
    alone_ = std::make_unique<Alone>(system, start, options, 1);
    return;
  }
  initial_mode(system, 0.0, start.state, start.p);
  in_lanes_ = std::make_unique<InLanes>(start, lane.parameters(), options, forcing_period(system, start.p));
}

RunningAverage::~RunningAverage() = default;

MotionTask<bool> RunningAverage::carry(TaskSlot& lane, std::int64_t periods) {
  if (alone_) {
    while (alone_->open() && alone_->periods() < periods && !alone_->cancelled()) alone_->carry_on();
    co_return alone_->open();
  }
  InLanes& average = *in_lanes_;
  std::vector<MotionStart> next;
  while (average.open() && average.periods() < periods && !average.cancelled()) {
    average.announce(lane.motions(), lane.parameters());
    average.ask(next);
    const std::size_t stretch = average.part_of(shortest_stretch);
    const std::span<const PeriodResult> carried = co_await lane.carry(next, stretch, average.with_tangents());
    average.take(carried.data(), stretch, 1);
  }
  co_return average.open();
}

const Vector& RunningAverage::state() const { return alone_ ? alone_->state() : in_lanes_->state(); }

LyapunovSpectrum RunningAverage::result() && { return alone_ ? std::move(*alone_).result() : std::move(*in_lanes_).result(); }

LyapunovSpectrum lane_spectrum(LaneCarrier& many, const Vector& start, const LyapunovOptions& options) {
  constexpr std::size_t set = 0;
  const Vector& p = many.parameters(set);
  validate(options);
  initial_mode(many.system(), 0.0, start, p);
  if (options.all_threads) many.use_all_threads();
  const std::size_t threads = options.all_threads ? available_threads() : 1;
  if (options.table) many.use(set, options.table);
  LaneMotions average({p, start}, set, options, forcing_period(many.system(), p));
  std::vector<MotionStart> motions;
  std::vector<PeriodResult> results;
  std::int64_t told = 0;
  for (std::size_t carried = 0; average.open() && !average.cancelled();) {
    average.announce(many, set);
    average.ask(motions);
    const std::size_t stretch = average.part_of(std::clamp(carried / 8, shortest_stretch, longest_stretch));
    many.carry(motions, stretch, average.with_tangents(), results);
    carried += stretch;
    average.take(results.data(), stretch, threads);
    if (options.progress && average.periods() > told) options.progress(told = average.periods());
  }
  return std::move(average).result();
}

LyapunovSpectrum frame_spectrum(const HybridSystem& system, const AverageStart& start, const LyapunovOptions& options) {
  validate(options);
  FrameMotions average(system, start, options, options.motions);
  std::int64_t told = 0;
  while (average.open() && !average.cancelled()) {
    average.carry_on();
    if (options.progress && average.periods() > told) options.progress(told = average.periods());
  }
  return std::move(average).result();
}

}  // namespace graze
