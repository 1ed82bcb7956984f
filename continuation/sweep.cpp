// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/sweep.hpp>

#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <mutex>
#include <stdexcept>

namespace graze {

namespace {

/// Rows whose time averages are taken side by side, where lanes know the oscillator: so many at the most, and fewer where they
/// would take longer than this, by the time of those before: a group is kept as a whole.
constexpr std::size_t rows_side_by_side = 16;
constexpr std::chrono::duration<double, std::milli> quick_group{250.0};
/// Groups that may wait for one before them whose averages take long. What is done meanwhile, lest threads wait, may be in vain.
constexpr std::size_t most_open = 1024;

/// The attractor that a motion comes to. Where it repeats itself to within `repeats` on its way, Newton's method is tried at
/// once; at its end all returns are.
Attractor followed(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  constexpr double repeats = 1e-4;
  AttractorOptions looking = options;
  looking.recurrence = repeats;
  Attractor attractor = approach_attractor(system, p, start, looking);
  if (attractor.type == AttractorType::periodic || attractor.termination != Termination::time) return attractor;
  if (auto orbit = settling_orbit(system, p, attractor.state, options.max_period, options.lyapunov.flow))
    settle_on(attractor, std::move(*orbit));
  return attractor;
}

/// Keeps of a row's orbit what it is, and not how it was found: there may be a million rows.
void describe_briefly(SweepRow& row) {
  if (!row.attractor.orbit) return;
  PeriodicOrbit& orbit = *row.attractor.orbit;
  orbit.nodes = {};
  orbit.signature = {};
  orbit.newton.residual_history = {};
  orbit.events = {};
  orbit.monodromy = {};
}

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
    finding_ = options.attractor;
    finding_.lyapunov.cancelled = options.cancelled;
    finding_.lyapunov.all_threads = true;
  }

  /// Follows the attractor to the end. Time averages are taken meanwhile; what they say may take rows back. `tell` is told how
  /// many rows are done, or taken back, and the value of the last. `ways`: how many directions are being followed.
  template <class Tell> void follow(const std::atomic<int>& ways, const Tell& tell) {
    rows_.reserve(values_.size());  // they stay where they are
    std::deque<Group> open;
    const auto unbegun = [](const Group& group) { return !group.begun; };
    for (;;) {
      const auto waiting = static_cast<std::size_t>(std::count_if(open.begin(), open.end(), unbegun));
      if (!open.empty() && open.front().done) {
        open.front().averages.wait();
        settle(open, tell);
      } else if (goes_on() && waiting <= others(ways) && open.size() < most_open) {
        go_on(open, tell);
      } else if (waiting > 0) {  // the first before all others: it may take their rows back
        average(*std::find_if(open.begin(), open.end(), unbegun));
      } else if (!open.empty()) {
        open.front().averages.wait();
      } else {
        return;
      }
    }
  }

  std::vector<SweepRow>& rows() { return rows_; }

 private:
  /// Rows, one behind the other, that wait for their time averages.
  struct Group {
    explicit Group(std::size_t number) : first(number) {}
    ~Group() {
      try {
        averages.wait();
      } catch (...) {  // whoever waits for rows that are kept is told
      }
    }
    std::size_t first, count = 0;
    std::atomic<bool> begun = false, done = false;
    std::chrono::steady_clock::duration taken{};
    oneapi::tbb::task_group averages;
  };

  bool goes_on() const { return !ended_ && rows_.size() < values_.size() && rows_.size() <= last_; }
  /// Threads that have nothing else to do.
  std::size_t others(int ways) const { return static_cast<std::size_t>(std::max(0, options_.threads - ways)); }

  /// To the end of the next group of rows that are not periodic.
  template <class Tell> void go_on(std::deque<Group>& open, const Tell& tell) {
    const Vector p = parameters(values_[rows_.size()]);
    const std::size_t together = ManyMotions::applies(system_, p, finding_.lyapunov.flow) ? together_ : 1;
    Group* group = nullptr;
    while (goes_on() && !(group && group->count == together)) {
      auto row = next();
      ended_ = !row;
      if (ended_) break;
      rows_.push_back(std::move(*row));
      if (rows_.back().attractor.type == AttractorType::periodic) {
        tell(1, rows_.back().value);
        if (group) break;
      } else {
        if (!group) group = &open.emplace_back(rows_.size() - 1);
        ++group->count;
      }
    }
    if (group) group->averages.run([this, group] { average(*group); });
  }

  /// Unless another thread does.
  void average(Group& group) {
    if (group.begun.exchange(true)) return;
    const auto begin = std::chrono::steady_clock::now();
    AttractorOptions averaging = finding_;
    averaging.lyapunov.cancelled = [&] { return group.first > last_ || (options_.cancelled && options_.cancelled()); };
    std::vector<AttractorAt> which;
    for (std::size_t k = group.first; k < group.first + group.count; ++k) {
      rows_[k].attractor.state = rows_[k].end;
      which.push_back({parameters(rows_[k].value), &rows_[k].attractor});
    }
    try {
      average_on_each_attractor(system_, which, averaging);
    } catch (...) {  // whoever waits for it is told
      group.done = true;
      throw;
    }
    group.taken = std::chrono::steady_clock::now() - begin;
    for (std::size_t k = group.first; k < group.first + group.count; ++k)
      if (ends_the_rows(rows_[k])) end_with(k);
    group.done = true;
  }

  /// Whether the time average of a row that looked chaotic ended on an orbit, from which those behind have to start, or was
  /// broken off.
  static bool ends_the_rows(const SweepRow& row) {
    const LyapunovStop stop = row.attractor.time_average.stop;
    return row.attractor.type == AttractorType::periodic || stop == LyapunovStop::interrupted || stop == LyapunovStop::failed ||
           stop == LyapunovStop::not_run;
  }
  void end_with(std::size_t row) {
    std::size_t last = last_;
    while (row < last && !last_.compare_exchange_weak(last, row)) {
    }
  }

  /// Keeps the rows of the first group up to one whose average was broken off, or turned out to end on an orbit.
  template <class Tell> void settle(std::deque<Group>& open, const Tell& tell) {
    const std::size_t begin = open.front().first, end = begin + open.front().count;
    const double of_a_row = open.front().taken / quick_group / static_cast<double>(end - begin);
    together_ = static_cast<std::size_t>(std::clamp(1.0 / of_a_row, 1.0, static_cast<double>(rows_side_by_side)));
    open.pop_front();
    for (std::size_t k = begin; k < end; ++k) {
      const bool last = k == last_, broken_off = last && rows_[k].attractor.type != AttractorType::periodic;
      if (!broken_off) tell(1, rows_[k].value);
      if (!last) continue;
      take_back(open, k, end - (k + 1), tell);
      broken_off ? rows_.pop_back() : sample(rows_[k]);
      ended_ = broken_off;
      return;
    }
  }

  /// Gives up the rows behind row k, of which so many and those of the open groups have not been told of.
  template <class Tell> void take_back(std::deque<Group>& open, std::size_t k, std::size_t untold, const Tell& tell) {
    for (const Group& other : open) untold += other.count;
    open.clear();
    last_ = no_last;
    const auto told = static_cast<std::ptrdiff_t>(rows_.size() - (k + 1) - untold);
    rows_.resize(k + 1);
    if (told > 0) tell(-told, rows_[k].value);
  }

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
      row.attractor = followed(system_, parameters(row.value), rows_.empty() ? start_ : rows_.back().end, finding);
    } catch (const std::invalid_argument&) {  // the state before lies inside the barrier of this value
      return std::nullopt;
    }
    if (row.attractor.termination != Termination::time || (options_.cancelled && options_.cancelled())) return std::nullopt;
    if (row.attractor.type == AttractorType::periodic)
      average_on_attractor(system_, parameters(row.value), row.attractor, finding_);
    if (row.attractor.time_average.stop == LyapunovStop::interrupted) return std::nullopt;
    sample(row);
    return row;
  }

  void sample(SweepRow& row) const {
    row.states.clear();
    row.impact_speeds.clear();
    const std::optional<PeriodicOrbit>& orbit = row.attractor.orbit;
    if (orbit && (orbit->impacts == 0 || !orbit->events.empty())) {
      row.states = orbit->states;
      for (const EventRecord& event : orbit->events)
        if (begins_contact(event.kind)) row.impact_speeds.push_back(event.normal_speed);
      row.end = orbit->state;
    } else {
      follow_samples(row);
    }
    describe_briefly(row);
  }

  void follow_samples(SweepRow& row) const {
    const Vector p = parameters(row.value);
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
  bool ended_ = false;
  std::size_t together_ = 1;  ///< rows of the next group
  /// Rows behind this one are given up: it ends on an orbit, or was broken off, as one of the open groups has found out.
  static constexpr std::size_t no_last = std::numeric_limits<std::size_t>::max();
  std::atomic<std::size_t> last_ = no_last;
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
  std::deque<OneWay> ways;
  for (const SweepDirection direction : options.directions) ways.emplace_back(system, p, start, options, direction, so_far);
  oneapi::tbb::task_arena arena(std::max(1, options.threads));
  std::atomic<int> active = static_cast<int>(ways.size());
  std::mutex telling;
  auto done = static_cast<std::ptrdiff_t>(so_far.size());
  const auto tell = [&](std::ptrdiff_t more, double value) {
    const std::lock_guard lock(telling);
    done += more;
    if (options.progress) options.progress(static_cast<std::size_t>(done), value);
  };
  arena.execute([&] {
    oneapi::tbb::task_group group;
    for (OneWay& way : ways)
      group.run([&] {
        way.follow(active, tell);
        --active;
      });
    group.wait();
  });
  std::vector<SweepRow> all;
  for (OneWay& way : ways) std::move(way.rows().begin(), way.rows().end(), std::back_inserter(all));
  return all;
}

}  // namespace graze
