// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <graze/lib/lanes/oscillator.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace graze {

namespace {

/// Number of contacts met before a table is made. The table covers their speeds except for the slowest and the fastest 0.1 %.
constexpr std::int64_t contacts_before_table = 2000;
constexpr double too_few = 0.001;
/// Motions that fill the lanes of one thread.
constexpr std::size_t fewest_on_a_thread = 8;
/// Runs that may join in one call.
constexpr std::size_t most_to_join = 4096;
/// Finest tolerance with tables: there the lanes' series are as accurate as a table, and a finer tolerance asks for more.
constexpr double finest_tolerance = 1e-13;

SpeedRange speeds_of(const lanes::SpeedHistogram& met) {
  const auto& n = met.of_band;
  const auto all = static_cast<double>(std::accumulate(n.begin(), n.end(), std::int64_t{0}));
  std::size_t first = 0, last = n.size() - 1;
  for (double slower = 0.0; first < last; ++first)
    if ((slower += static_cast<double>(n[first])) > too_few * all) break;
  for (double faster = 0.0; last > first; --last)
    if ((faster += static_cast<double>(n[last])) > too_few * all) break;
  const auto speed = [](std::size_t band) { return std::ldexp(1.0, static_cast<int>(band) + lanes::SpeedHistogram::lowest); };
  return {speed(first), speed(last)};
}

}  // namespace

ImpactSpeeds::ImpactSpeeds() {
  add = [](lanes::SpeedRecorder& notes, double speed) {
    auto& self = static_cast<ImpactSpeeds&>(notes);
    self.list_.resize(self.count++);
    self.list_.push_back(speed);
  };
}

struct LaneCarrier::Set {
  Vector p;
  lanes::Oscillator oscillator;
  double period;
  std::unique_ptr<Propagator> propagator = nullptr;  ///< for periods that the lanes give up; made on demand
  bool awaits_table = false;
  lanes::SpeedHistogram met = {};  ///< filled while awaits_table
  std::shared_ptr<const ContactTable> table = nullptr;
  lanes::ContactPieces pieces = {};  ///< view of the table
};

/// A run with periods left, and its parameter set.
struct LaneCarrier::Going {
  MotionRun* run;
  Set* set;
};

bool LaneCarrier::is_linear(const Going& one) { return !one.set->oscillator.cubic; }

bool LaneCarrier::applies(const HybridSystem& system, const Vector& p, const FlowOptions& options) {
  return options.kind == FlowKind::automatic && lanes::lanes_support(system, p);
}

LaneCarrier::LaneCarrier(const SharedSystem& system, const FlowOptions& options, LaneWidth width)
    : system_(system), options_(options), width_(width) {
  lane_kernels(width);  // or throws
  validate(options);
}

void record_contacts(const std::vector<EventRecord>& events, lanes::SpeedRecorder& speeds) {
  for (const EventRecord& event : events)
    if (begins_contact(event.kind)) speeds.add(speeds, event.normal_speed);
}

std::size_t motions_at_once(const HybridSystem& system, const Vector& p, const FlowOptions& options) {
  return LaneCarrier::applies(system, p, options) ? motions_in_lanes : 1;
}

std::unique_ptr<LaneCarrier> make_lane_carrier(const SharedSystem& system, std::span<const Vector> sets,
                                               const FlowOptions& options) {
  const auto supported = [&](const Vector& p) { return LaneCarrier::applies(system, p, options); };
  if (!std::all_of(sets.begin(), sets.end(), supported)) return nullptr;
  auto carrier = std::make_unique<LaneCarrier>(system, options);
  for (const Vector& p : sets) carrier->add_parameters(p);
  return carrier;
}

LaneCarrier::~LaneCarrier() = default;

void LaneCarrier::DeleteSet::operator()(Set* set) const { delete set; }

LaneCarrier::OwnSet LaneCarrier::make_set(const Vector& p) {
  check_parameters(system_->parameters, p);
  const auto oscillator = options_.kind == FlowKind::automatic ? lanes::lane_oscillator(*system_, p) : std::nullopt;
  if (!oscillator || (law_ && *law_ != oscillator->law))
    throw std::invalid_argument(
        fmt::format("{} at these parameters is not an oscillator that the lanes know (linear and underdamped or with a cubic "
                    "spring, one barrier with restitution, of Hertz's law or linear elastic); carry its motions one by one",
                    system_->name));
  law_ = oscillator->law;
  return OwnSet(new Set{p, *oscillator, forcing_period(*system_, p)});
}

std::size_t LaneCarrier::add_parameters(const Vector& p) {
  sets_.push_back(make_set(p));
  return sets_.size() - 1;
}

void LaneCarrier::change_parameters(std::size_t parameters, const Vector& p) {
  check_set(parameters);
  sets_[parameters] = make_set(p);
}

const Vector& LaneCarrier::parameters(std::size_t parameters) const { return set_of(parameters).p; }

LaneCarrier::Taken LaneCarrier::take(std::size_t parameters) {
  set_of(parameters);
  return Taken(std::move(sets_[parameters]));
}

std::size_t LaneCarrier::add(Taken taken, std::optional<std::size_t> place) {
  law_ = taken.set_->oscillator.law;
  if (!place) place = sets_.size();
  if (*place == sets_.size()) sets_.emplace_back();
  sets_[*place] = std::move(taken.set_);
  return *place;
}

void LaneCarrier::check_set(std::size_t parameters) const {
  if (parameters >= sets_.size())
    throw std::invalid_argument(
        fmt::format("a motion has parameter set {}; {} were added (counted from 0)", parameters, sets_.size()));
}

LaneCarrier::Set& LaneCarrier::set_of(std::size_t parameters) const {
  check_set(parameters);
  if (!sets_[parameters]) throw std::invalid_argument(fmt::format("parameter set {} was taken", parameters));
  return *sets_[parameters];
}

void LaneCarrier::expect(std::size_t parameters, std::int64_t periods) {
  Set& set = set_of(parameters);
  if (set.oscillator.tabulated() && !set.table && periods >= periods_for_table && options_.tolerance >= finest_tolerance)
    set.awaits_table = true;
}

void LaneCarrier::use(std::size_t parameters, std::shared_ptr<const ContactTable> table) {
  Set& set = set_of(parameters);
  if (!table->made_for(set.oscillator.coefficients))
    throw std::invalid_argument(fmt::format("the table of contacts is not one of parameter set {}", parameters));
  set.awaits_table = false;
  set.table = std::move(table);
  set.pieces = set.table->pieces();
}

std::shared_ptr<const ContactTable> LaneCarrier::table(std::size_t parameters) const { return set_of(parameters).table; }

bool LaneCarrier::awaits_table(std::size_t parameters) const { return set_of(parameters).awaits_table; }

void LaneCarrier::make_pending_table(std::size_t parameters) { make_pending_table(set_of(parameters)); }

/// Makes the table of a set that awaits one, if it has met enough contacts.
void LaneCarrier::make_pending_table(Set& set) {
  const auto& met = set.met.of_band;
  if (!set.awaits_table || std::accumulate(met.begin(), met.end(), std::int64_t{0}) < contacts_before_table) return;
  set.awaits_table = false;
  set.table = std::make_shared<const ContactTable>(*system_, set.p, speeds_of(set.met), width_);
  set.pieces = set.table->pieces();
}

bool LaneCarrier::carry_by_propagator(const lanes::Motion& motion, std::size_t period, bool tangent) {
  const std::lock_guard lock(left_over_lock_);
  ++left_over_;
  Set& set = *sets_[motion.parameters];
  if (!set.propagator) set.propagator = std::make_unique<Propagator>(system_, set.p, std::vector<std::size_t>{}, options_);
  const bool first = period == 0;
  const PeriodResult& before = motion.result(first ? 0 : period - 1);
  const Vector at{{first ? motion.x : before.x, first ? motion.v : before.v}};
  const TransitionOptions carrying{.sensitivity = tangent ? Sensitivity::state : Sensitivity::none,
                                   .keep_events = motion.notes != nullptr};
  graze::carry(*set.propagator, 0.0, set.period, at, carrying, transition_);
  if (motion.notes) record_contacts(transition_.events, *motion.notes);
  PeriodResult& out = motion.result(period) = {};
  out.termination = transition_.termination;
  out.by_propagator = true;
  if (out.termination != Termination::time) return false;
  out.x = transition_.x1[0];
  out.v = transition_.x1[1];
  if (tangent) out.Phi = {transition_.Phi(0, 0), transition_.Phi(0, 1), transition_.Phi(1, 0), transition_.Phi(1, 1)};
  out.det = std::exp(transition_.log_det);
  out.liouville = transition_.liouville;
  out.impacts = contacts_among(transition_.event_sequence, system_);
  return true;
}

void LaneCarrier::carry_in_lanes(std::size_t begin, std::size_t end, bool tangent) {
  const LaneWidth width = width_ == LaneWidth::widest ? width_for(end - begin) : width_;
  lanes::Job job{*law_, !linear_, options_.tolerance, options_.max_steps, tangent};
  job.motions = motions_.data() + begin;
  job.count = end - begin;
  job.carried = carried_each_.data() + begin;
  job.ellipses = ellipses_.data();
  job.ellipse_count = ellipses_.size();
  job.whom = this;
  job.carry_given_up = [](void* self, const lanes::Job& its, const lanes::Motion& motion, std::size_t period) {
    return static_cast<LaneCarrier*>(self)->carry_by_propagator(motion, period, its.tangent);
  };
  if (supply_) {
    job.while_full = true;
    job.more = [](void* self, std::size_t number, std::size_t taken) {
      auto& many = *static_cast<LaneCarrier*>(self);
      many.taken_ = taken;
      many.finish(number);
      many.supply_->through(*many.supply_, *many.together_[number].run, many.carried_each_[number].periods);
      return many.motions_.size();
    };
  }
  lane_kernels(width).carry(job);
}

void LaneCarrier::carry(const std::vector<MotionStart>& starts, std::size_t periods, bool tangent,
                        std::vector<PeriodResult>& results) {
  results.resize(starts.size() * periods);
  std::vector<MotionRun> runs;
  runs.reserve(starts.size());
  for (std::size_t m = 0; m < starts.size(); ++m) runs.push_back({starts[m], periods, results.data() + m * periods});
  carry(runs, tangent);
}

void LaneCarrier::carry(std::span<MotionRun> runs, bool tangent) {
  going_.clear();
  for (MotionRun& run : runs) {
    run.carried = 0;
    if (Set& set = set_of(run.start.parameters); run.periods > 0) going_.push_back({&run, &set});
  }
  while (!going_.empty()) {
    go_on(tangent);
    // Runs whose set awaits a table have stopped, so that it can be made now.
    for (const Going& one : going_) make_pending_table(*one.set);
    std::erase_if(going_, [](const Going& one) { return one.run->carried == one.run->periods; });
  }
}

void LaneCarrier::carry_while_full(std::span<MotionRun* const> runs, bool tangent, std::size_t most, RunSupply& supply) {
  going_.clear();
  for (MotionRun* const run : runs)
    if (Set& set = set_of(run->start.parameters); run->carried < run->periods) going_.push_back({run, &set});
  supply_ = &supply;
  most_ = most;
  const struct Forgetting {
    RunSupply*& supply;
    ~Forgetting() { supply = nullptr; }
  } until_the_end{supply_};
  go_on(tangent);
}

void LaneCarrier::go_on(bool tangent) {
  const auto cubic = std::stable_partition(going_.begin(), going_.end(), is_linear);
  carry_alike({going_.begin(), cubic}, tangent);
  carry_alike({cubic, going_.end()}, tangent);
}

bool LaneCarrier::join(MotionRun& run) {
  const Going one{&run, &set_of(run.start.parameters)};
  if (is_linear(one) != linear_ || one.set->table || one.set->awaits_table) return false;
  if (motions_.size() == room_) return false;
  together_.push_back(one);
  motions_.push_back(next_of(one));
  carried_each_.emplace_back();
  if (run.goes_first) {
    std::swap(together_[taken_], together_.back());
    std::swap(motions_[taken_], motions_.back());
  }
  return true;
}

/// The part of a run that the lanes carry next.
lanes::Motion LaneCarrier::next_of(const Going& one) const {
  const auto& [run, set] = one;
  const MotionStart now = run->now();
  std::size_t periods = run->periods - run->carried;
  if (!supply_ && !run->watch && set->awaits_table) periods = std::min(periods, periods_between_looks);
  if (supply_ && !set->table && !run->goes_first) periods = std::min(periods, most_);
  return {now.x,
          now.v,
          now.parameters,
          &set->oscillator.coefficients,
          set->oscillator.grid.get(),
          &set->oscillator.pressed,
          set->oscillator.pressed_grid.get(),
          periods,
          run->results + run->carried,
          set->table ? &set->pieces : nullptr,
          set->awaits_table ? &set->met : nullptr,
          run->speeds,
          run->watch};
}

void LaneCarrier::carry_alike(std::span<const Going> going, bool tangent) {
  if (going.empty()) return;
  linear_ = is_linear(going.front());
  together_.clear();
  motions_.clear();
  carried_each_.clear();
  if (supply_) {
    // The lanes hold pointers into these arrays: nothing may be reallocated while they run.
    room_ = going.size() + most_to_join;
    together_.reserve(room_);
    motions_.reserve(room_);
    carried_each_.reserve(room_);
  }
  for (const Going& one : going) {
    together_.push_back(one);
    motions_.push_back(next_of(one));
    carried_each_.emplace_back();
  }
  const std::size_t count = going.size();
  if (supply_) return carry_in_lanes(0, count, tangent);
  const std::size_t parts = all_threads_ ? std::clamp<std::size_t>(count / fewest_on_a_thread, 1, available_threads()) : 1;
  in_parallel(parts, [&](std::size_t i) { carry_in_lanes(i * count / parts, (i + 1) * count / parts, tangent); });
  for (std::size_t i = 0; i < count; ++i) finish(i);
}

/// Stores the progress of a run.
void LaneCarrier::finish(std::size_t number) {
  MotionRun& run = *together_[number].run;
  const lanes::Carried& carried = carried_each_[number];
  run.carried += carried.periods;
  carried_ += carried.periods + (carried.failed ? 1 : 0);
  if (run.watch) {
    run.periods = run.carried;
    if (carried.failed) run.watch->see(*run.watch, run.carried + 1, *run.results);
    return;
  }
  if (!carried.failed) return;
  PeriodResult* const end = run.results + run.carried;
  std::fill(end + 1, run.results + run.periods, PeriodResult{.termination = end->termination});
  run.carried = run.periods;
}

}  // namespace graze
