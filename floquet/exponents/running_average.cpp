// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/exponents/exponents.hpp>
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/lib/numerics/parallel.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

namespace graze {

namespace {

/// An average that may stop early is expected to be long once it has reached this many periods.
constexpr std::int64_t lasting = LaneCarrier::periods_for_table / 4;
/// Periods per motion from which the use of several threads pays.
constexpr std::size_t long_for_threads = 64;

/// Shortest length of a motion in an average over several: the periods in which they separate do not count and are a small part.
constexpr std::int64_t shortest_motion = 10 * decorrelation_periods;

/// Number of chaotic motions averaged in parallel, if several are carried at once. It fills the lanes of one thread, provided
/// that most of each motion's budget remains after parting. It grows up to the lanes of several threads if each motion lasts for
/// at least `shortest_motion`.
constexpr std::int64_t motions_of_a_thread = 16, most_motions = 128;
constexpr std::int64_t budget_for_many = 4 * motions_of_a_thread * decorrelation_periods;

/// Expected length of an average: its budget, or the periods after which the standard error reaches its bound. (The growth per
/// period has a standard deviation of about 1/3, and a period is about 2 pi long.)
std::int64_t expected_periods(const LyapunovOptions& averaging) {
  const double per_error = 3.0 * averaging.standard_error * 2.0 * std::numbers::pi;
  return static_cast<std::int64_t>(
      std::min(static_cast<double>(averaging.max_periods), per_error > 0.0 ? 1.0 / (per_error * per_error) : 1e18));
}

int motions_side_by_side(const LyapunovOptions& averaging) {
  if (averaging.change > 0.0 || averaging.max_periods < budget_for_many) return 1;
  const std::int64_t wanted = expected_periods(averaging) / shortest_motion;
  return static_cast<int>(std::clamp(wanted / motions_of_a_thread * motions_of_a_thread, motions_of_a_thread, most_motions));
}

/// The same if motions are carried one by one: several threads share them. The number depends on the length alone, so that the
/// result does not depend on the machine.
int motions_one_by_one(const LyapunovOptions& averaging) {
  constexpr std::int64_t step = 4, most = 32;
  const std::int64_t wanted = expected_periods(averaging) / shortest_motion;
  if (averaging.change > 0.0 || wanted < step) return 1;
  return static_cast<int>(std::min(wanted / step * step, most));
}

}  // namespace

int enough_motions(const HybridSystem& system, const Vector& p, const LyapunovOptions& averaging) {
  return motions_at_once(system, p, averaging.flow) > 1 ? motions_side_by_side(averaging) : motions_one_by_one(averaging);
}

int motions_in_company(const LyapunovOptions& averaging) {
  const int alone = motions_side_by_side(averaging);
  return expected_periods(averaging) < 4 * decorrelation_periods * alone ? 1 : alone;
}

std::vector<Vector> neighbouring_starts(const HybridSystem& system, const Vector& p, const Vector& state, int motions) {
  const auto neighbour = [&](int i) {
    for (Eigen::Index k = 0; k < state.size(); ++k)
      for (const double side : {-1e-7, 1e-7}) {
        Vector moved = state;
        moved[k] += side * (1.0 + std::abs(state[k])) * i;
        if (mode_at(system, 0.0, moved, p)) return moved;
      }
    return state;
  };
  std::vector<Vector> starts{state};
  for (int i = 1; i < motions; ++i) starts.push_back(neighbour(i));
  return starts;
}

RunningAverage::RunningAverage(const TaskSlot& slot, const AverageStart& start, const LyapunovOptions& options)
    : options_(options),
      forced_interval_(is_forced(slot.system()) ? options.interval * forcing_period(slot.system(), start.p) : 0.0),
      lost_(slot.system()->states, 0), last_(slot.system()->states, 0.0) {
  validate(options);
  const HybridSystem& system = slot.system();
  initial_mode(system, 0.0, start.state, start.p);
  if (options.table) slot.use(options.table);
  states_ = neighbouring_starts(system, start.p, start.state, options.motions);
  motions_.assign(states_.size(), MotionGrowth(system.states, is_forced(system)));
  uncounted_ = std::max<std::int64_t>(options.aligning, motions_.size() > 1 ? aligning_periods : 0);
  to_part_ = motions_.size() > 1 ? std::max<std::int64_t>(0, decorrelation_periods - uncounted_) : 0;
  out_.stop = LyapunovStop::budget;
  open_ = options.max_periods >= round();
}

MotionTask<bool> RunningAverage::carry(TaskSlot& slot, std::int64_t periods, std::size_t most_at_once) {
  while (open_ && out_.periods < periods && !cancelled()) {
    announce(slot);
    // An eighth of the periods so far, so that few more are carried than needed.
    std::size_t next = slot.batch(std::clamp(requested_ / 8, fewest_at_once, most_at_once), motions_.size());
    if (is_parting()) next = std::min(next, static_cast<std::size_t>(to_part_));
    requested_ += next;
    const CarriedMotions carried = co_await slot.carry_all(states_, next, !is_parting());
    const std::int64_t before = out_.periods;
    add(carried, next, slot.all_threads());
    if (options_.progress && out_.periods > before) options_.progress(out_.periods);
  }
  co_return open_;
}

/// Asks whether the average is cancelled, which ends it.
bool RunningAverage::cancelled() {
  if (!options_.cancelled || !options_.cancelled()) return false;
  stop(LyapunovStop::interrupted);
  return true;
}

/// Tells how many periods will follow, once that is known.
void RunningAverage::announce(const TaskSlot& slot) {
  const bool to_the_end = options_.standard_error == 0.0 && options_.change == 0.0;
  if (announced_ || (!to_the_end && out_.periods < lasting)) return;
  announced_ = true;
  slot.expect(options_.max_periods - out_.periods);
}

/// Adds some more periods of each motion, in parts between two tests of the stop rule.
void RunningAverage::add(const CarriedMotions& carried, std::size_t periods, bool all_threads) {
  if (is_parting()) {
    add_part(carried, 0, periods, all_threads);
    to_part_ -= static_cast<std::int64_t>(periods);
  } else {
    for (std::size_t k = 0; k < periods && open_;) {
      const std::size_t next = std::min<std::size_t>(periods - k, static_cast<std::size_t>(until_look()));
      const bool counted = uncounted_ == 0;
      add_part(carried, k, next, all_threads);
      k += next;
      if (!open_) break;
      if (!counted)
        uncounted_ -= static_cast<std::int64_t>(next);
      else if (motions_.front().periods_open() == 0)
        look();
    }
  }
}

/// Adds `count` periods of each motion, from `begin` on. The average ends if a motion has.
void RunningAverage::add_part(const CarriedMotions& carried, std::size_t begin, std::size_t count, bool all_threads) {
  using Kind = MotionGrowth::Kind;
  const Kind kind = is_parting() ? Kind::parting : uncounted_ > 0 ? Kind::aligning : Kind::counted;
  for_each_index(all_threads && count >= long_for_threads, motions_.size(),
                 [&](std::size_t i) { motions_[i].add(carried.of(i).part(begin, count), kind, options_.interval, states_[i]); });
  gather();
  if (out_.termination != Termination::time) stop(LyapunovStop::failed);
}

void RunningAverage::stop(LyapunovStop reason) {
  if (open_) out_.stop = reason;
  open_ = false;
}

/// Periods until the next test: the motions begin to count, have a new standard error, or may end.
std::int64_t RunningAverage::until_look() const {
  if (uncounted_ > 0) return uncounted_;
  const MotionGrowth& first = motions_.front();
  const std::int64_t to_end = (options_.max_periods - out_.periods) / static_cast<std::int64_t>(motions_.size());
  const std::int64_t intervals = options_.change > 0.0 || lost_[0] ? 1 : first.means(0).until_batch_ends();
  return std::max<std::int64_t>(1, std::min(intervals * options_.interval - first.periods_open(), to_end));
}

/// Collects the sums over all motions.
void RunningAverage::gather() {
  out_.impacts = 0;
  out_.periods = 0;
  out_.duration = out_.log_growth = out_.log_volume = 0.0;
  out_.termination = Termination::time;
  for (const MotionGrowth& motion : motions_) {
    out_.impacts += motion.impacts();
    out_.periods += motion.averaged();
    if (const ReturnTimes* const times = motion.times()) out_.duration += times->total();
    out_.log_growth += motion.means(0).total() / count();
    out_.log_volume += motion.log_volume() / count();
    out_.liouville_residual = std::max(out_.liouville_residual, motion.liouville_residual());
    for (std::size_t i = 0; i < lost_.size(); ++i) lost_[i] = lost_[i] || motion.lost(i);
    if (motion.termination() != Termination::time) out_.termination = motion.termination();
  }
}

/// Applies the stop rule after an orthonormalisation of all motions.
void RunningAverage::look() {
  if (options_.change > 0.0) {
    double change = 0.0;
    for (std::size_t i = 0; i < lost_.size(); ++i) {
      const double before = std::exchange(last_[i], lost_[i] ? 0.0 : exponent(i));
      change = std::max(change, std::abs(last_[i] - before));
    }
    if (out_.periods > round() && change < options_.change) return stop(LyapunovStop::change);
  }
  // They end the average, and have changed.
  const bool has_errors = options_.change == 0.0 && options_.standard_error > 0.0;
  if (has_errors && (lost_[0] || motions_.front().means(0).ended_batch()) && settled()) return stop(LyapunovStop::standard_error);
  if (out_.periods + round() > options_.max_periods) open_ = false;
}

/// Whether the bounds of the options are met.
bool RunningAverage::settled() const {
  const std::int64_t each = out_.periods / static_cast<std::int64_t>(motions_.size());
  if (options_.significance > 0.0 && !grows_beyond_shear(out_.log_growth, out_.log_volume, each)) return false;
  if (out_.periods < options_.min_periods || std::abs(exponent(0)) < options_.significance * standard_error(0)) return false;
  for (std::size_t i = 0; i < lost_.size(); ++i)
    if (!(standard_error(i) < options_.standard_error)) return false;
  return true;
}

/// Mean time of an interval.
double RunningAverage::interval_time() const {
  if (forced_interval_ > 0.0) return forced_interval_;
  return out_.duration / static_cast<double>(std::max<std::int64_t>(out_.periods, 1)) * options_.interval;
}

double RunningAverage::exponent(std::size_t i) const {
  if (lost_[i]) return -std::numeric_limits<double>::infinity();
  double sum = 0.0;
  std::int64_t terms = 0;
  for (const MotionGrowth& motion : motions_) {
    sum += motion.means(i).total();
    terms += motion.means(i).count();
  }
  return sum / static_cast<double>(std::max<std::int64_t>(terms, 1)) / interval_time();
}

/// The motions are independent, except for the ends of their series: near an orbit they do not separate. If they differ by more
/// than their own errors explain (some have settled, or their correlation lasts longer than the average), their spread gives the
/// error.
double RunningAverage::standard_error(std::size_t i) const {
  if (lost_[i]) return 0.0;
  const double rate = forced_interval_ > 0.0 ? 0.0 : exponent(i);
  double squares = 0.0, edges = 0.0, mean = 0.0, apart = 0.0, drift = 0.0;
  // Growth of the direction in an interval beyond that of the common rate in the motion's own time.
  const auto beyond = [&](const MotionGrowth& motion) {
    const ReturnTimes* const times = motion.times();
    return motion.means(i).mean() - (times ? rate * times->mean() : 0.0);
  };
  for (const MotionGrowth& motion : motions_) {
    const BatchMeans& growth = motion.means(i);
    const ReturnTimes* const times = motion.times();
    const double own = times ? times->error(i, growth, rate) : growth.standard_error();
    squares += own * own;
    edges += growth.edge() / count();
    mean += beyond(motion) / count();
    drift += (times ? times->drift(growth, rate) : growth.drift()) / count();
  }
  for (const MotionGrowth& motion : motions_) apart += (beyond(motion) - mean) * (beyond(motion) - mean);
  const double spread = motions_.size() > 1 ? apart / (count() - 1.0) / count() : 0.0;
  return with_trend(std::sqrt(std::max(squares / (count() * count()), spread) + edges * edges), drift) / interval_time();
}

LyapunovSpectrum RunningAverage::result() && {
  std::vector<std::size_t> order(lost_.size());  // of the directions, largest exponent first
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return exponent(a) > exponent(b); });
  for (const std::size_t i : order) {
    double correlation = 0.0;
    for (const MotionGrowth& motion : motions_) correlation += motion.means(i).correlation_time();
    out_.exponents.push_back(exponent(i));
    out_.standard_errors.push_back(standard_error(i));
    out_.correlation_times.push_back(lost_[i] ? 0.0 : correlation / count() * options_.interval);
  }
  out_.kaplan_yorke = kaplan_yorke_dimension(out_.exponents);
  out_.state = state();
  out_.others.assign(states_.begin() + 1, states_.end());
  return std::move(out_);
}

}  // namespace graze
