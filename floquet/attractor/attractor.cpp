// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor_decision.hpp>
#include <graze/floquet/attractor/attractor_task.hpp>
#include <graze/floquet/attractor/refused_orbits.hpp>
#include <graze/floquet/attractor/transient.hpp>
#include <graze/floquet/exponents/running_average.hpp>
#include <graze/lib/numerics/parallel.hpp>
#include <graze/lib/tasks/observe.hpp>

#include <algorithm>
#include <functional>

namespace graze {

std::string_view attractor_type_name(AttractorType type) {
  switch (type) {
  case AttractorType::undecided:
    break;
  case AttractorType::periodic:
    return "periodic";
  case AttractorType::chaotic:
    return "chaotic";
  }
  return "undecided";
}

std::string_view conservative_motion_name(ConservativeMotion motion) {
  switch (motion) {
  case ConservativeMotion::unknown:
    break;
  case ConservativeMotion::neutral:
    return "neutral";
  case ConservativeMotion::island:
    return "island";
  case ConservativeMotion::chaotic_sea:
    return "chaotic sea";
  }
  return "undecided";
}

void describe_orbit(Attractor& attractor, const StableOrbit& orbit) {
  attractor.type = AttractorType::periodic;
  attractor.termination = Termination::time;
  attractor.period = orbit.period;
  attractor.impacts = orbit.impacts;
  attractor.isolated_impacts = orbit.isolated_impacts;
  attractor.rests = orbit.rests;
  attractor.conservative = orbit.conservative;
  attractor.motion = orbit.neutral() ? ConservativeMotion::neutral : ConservativeMotion::unknown;
  attractor.state = orbit.states.front();
  attractor.multipliers = orbit.multipliers.values;
  attractor.exponents = orbit.multipliers.exponents;
  if (orbit.multipliers.section == Section::autonomous) attractor.duration = orbit.duration;
  // The trivial ones come last.
  std::fill(attractor.exponents.end() - orbit.multipliers.trivial, attractor.exponents.end(), 0.0);
  if (orbit.multipliers.trivial > 0) std::stable_sort(attractor.exponents.begin(), attractor.exponents.end(), std::greater<>());
  attractor.standard_errors.assign(attractor.exponents.size(), 0.0);
  attractor.orbit.reset();
}

void settle_on(Attractor& attractor, StableOrbit orbit) {
  describe_orbit(attractor, orbit);
  attractor.orbit = std::make_shared<const StableOrbit>(std::move(orbit));
}

namespace {

/// Periods after which a running average is checked for a motion that has settled; the interval then doubles.
constexpr std::int64_t first_check_of_average = 2000;

bool is_fast(const AttractorOptions& options) { return options.recurrence > 0.0; }

/// Cancellation test, called before periods are carried.
struct Stop {
  const AttractorOptions& options;
  bool operator()() const { return cancelled(options); }
};

/// Whether the lanes may carry the motion: they give the orbits of fast searches only, and no average on an orbit.
bool alone(const AttractorOptions& options) { return !is_fast(options) || options.periods_on_orbit > 0; }

/// The orbit of up to `most` periods on which the motion at `state` is settling. `refused`: orbits that it was seen to pass.
MotionTask<OrbitSearchResult> look(TaskSlot& slot, const Vector& state, int most, const AttractorOptions& options,
                                   RefusedOrbits* refused = nullptr) {
  const OrbitSearch search{.max_period = most,
                           .nearness = is_fast(options) ? return_tolerance(options) : 0.0,
                           .refused = refused,
                           .all_threads = options.lyapunov.all_threads};
  return look_for_orbit(slot, state, search);
}

void average_on_orbit(const HybridSystem& system, const Vector& p, Attractor& attractor, const AttractorOptions& options) {
  LyapunovOptions averaging = options.lyapunov;
  averaging.max_periods = std::min<std::int64_t>(averaging.max_periods, options.periods_on_orbit);
  if (averaging.max_periods >= averaging.interval)
    attractor.time_average = lyapunov_spectrum(system, p, attractor.state, averaging);
}

/// The states of the averaged motions after a further 2000 forcing periods in total. Motions averaged in parallel are short,
/// and the chaos may be transient.
std::vector<Vector> continued_states(const HybridSystem& system, const Vector& p, const LyapunovSpectrum& average,
                                     const LyapunovOptions& averaging) {
  constexpr int in_all = 2000;
  std::vector<Vector> states = average.others;
  states.insert(states.begin(), average.state);
  if (states.size() == 1 || average.stop == LyapunovStop::interrupted) return states;
  const auto periods = static_cast<std::size_t>(std::max(1, in_all / averaging.motions));
  const auto go_on = [&](std::size_t k, TaskSlot& slot) -> MotionTask<> {
    slot.set_parameters(p);
    const CarriedPeriods carried = co_await slot.carry(states[k], periods);
    if (carried.termination(periods - 1) == Termination::time) carried.state(periods - 1, states[k]);
  };
  run_tasks(system, averaging.flow, averaging.all_threads, states.size(), go_on);
  return states;
}

/// The orbit on which one of the motions of an average has settled, sought from the end of each. One settled motion proves that
/// the chaos was transient.
std::optional<StableOrbit> orbit_at_ends(const HybridSystem& system, const Vector& p, const LyapunovSpectrum& average,
                                         const LyapunovOptions& averaging, const AttractorOptions& options) {
  std::vector<Vector> ends = continued_states(system, p, average, averaging);
  if (ends.size() > 1) ends = settling_candidates(system, p, ends, options.lyapunov.flow, options.lyapunov.all_threads);
  const int most = longest_period_tried(options, average.periods_each());
  const std::size_t together = options.lyapunov.all_threads ? available_threads() : 1;
  for (std::size_t begin = 0; begin < ends.size() && !cancelled(options); begin += together) {
    std::vector<OrbitSearchResult> looked(std::min(together, ends.size() - begin));
    const auto look_from = [&](std::size_t i, TaskSlot& slot) -> MotionTask<> {
      slot.set_parameters(p);
      looked[i] = co_await look(slot, ends[begin + i], most, options);
    };
    run_tasks(system, options.lyapunov.flow, options.lyapunov.all_threads, looked.size(), look_from);
    if (cancelled(options)) break;  // some may have been tried in part
    for (OrbitSearchResult& one : looked)
      if (one.orbit) return std::move(one.orbit);
  }
  return std::nullopt;
}

/// Evaluates an average. (An autonomous motion may have come to an end where it does not return.)
void take(LyapunovSpectrum average, const AttractorOptions& options, Attractor& attractor) {
  if (average.termination != Termination::no_return) return evaluate_average(std::move(average), options, attractor);
  attractor.termination = Termination::no_return;
  attractor.state = average.state;
  attractor.time_average = std::move(average);
}

/// Takes an average of a motion that is not known to be periodic and evaluates it; in fast mode, with a second one to confirm
/// chaos. Ends at once if the motion has settled on an orbit during an average.
MotionTask<> take_average(TaskSlot& slot, LyapunovOptions averaging, const AttractorOptions& options, Attractor& attractor) {
  if (!is_fast(options)) {
    take(lyapunov_spectrum(slot.system(), slot.p(), attractor.state, averaging), options, attractor);
    co_return;
  }
  if (slot.motions_at_once() == 1) averaging.motions = 1;  // several would take longer, and others are carried meanwhile
  for (bool again = false;; again = true) {
    const AverageStart start{slot.p(), attractor.state};
    RunningAverage average(slot, start, averaging);
    RefusedOrbits refused;
    for (std::int64_t periods = first_check_of_average;; periods *= 2) {
      const bool open = co_await average.carry(slot, periods);
      if (!open) break;
      const int most = longest_period_tried(options, periods);
      OrbitSearchResult looked = co_await look(slot, average.state(), most, options, &refused);
      if (!looked.orbit) continue;
      settle_on(attractor, std::move(*looked.orbit));
      co_return;
    }
    take(std::move(average).result(), options, attractor);
    if (again || !needs_confirmation(options, attractor)) co_return;
  }
}

/// Averages a motion that is not known to be periodic. Returns whether it must be continued from its new state.
MotionTask<bool> average(TaskSlot& slot, int round, const LyapunovOptions& averaging, const AttractorOptions& options,
                         Attractor& attractor) {
  const Stop stop{options};
  const SharedSystem& system = slot.system();
  const Vector p = slot.p(), begin = attractor.state;
  co_await take_average(slot, averaging, options, attractor);
  if (attractor.type == AttractorType::periodic || attractor.termination != Termination::time) co_return false;
  LyapunovSpectrum& mean = attractor.time_average;
  // The state at an interruption means nothing: the remaining periods might have led elsewhere.
  if (stop()) mean.stop = LyapunovStop::interrupted;
  if (mean.stop == LyapunovStop::interrupted) co_return false;
  const int most = longest_period_tried(options, mean.periods_each());
  OrbitSearchResult looked;
  if (is_fast(options))
    looked = co_await look(slot, attractor.state, most, options);
  else
    looked.orbit = orbit_at_ends(system, p, mean, averaging, options);
  if (looked.orbit) {
    settle_on(attractor, std::move(*looked.orbit));
    co_return false;
  }
  const double T = period_time(system, p, mean);
  if (!stop() && mean.termination == Termination::time && may_be_laminar(attractor, round, T)) {
    if (!is_fast(options)) looked.closest = co_await closest_return(slot, attractor.state, most, return_tolerance(options));
    if (looked.closest > 0) {
      LaminarPhase watch = laminar_watch(attractor, looked.closest, T, options);
      co_await carry_watched(slot, watch, stop);
      if (!stop()) {
        watch.look_back(begin, mean.periods_each());
        co_await carry_watched(slot, watch, stop);
      }
      if (!stop() && goes_on(watch, system, p, round, attractor)) co_return true;
    }
  }
  if (stop()) {
    mean.stop = LyapunovStop::interrupted;  // it may have to be continued
    co_return false;
  }
  const bool too_short = attractor.type == AttractorType::undecided && !attractor.conservative && round < rounds_for_undecided;
  co_return is_fast(options) && too_short;
}

}  // namespace

MotionTask<Attractor> approach_attractor(TaskSlot& slot, const Vector& p, const Vector& start, const AttractorOptions& options) {
  const Stop stop{options};
  Transient approach(slot.system(), p, start, options);
  slot.set_parameters(p, alone(options));
  do {
    co_await carry_watched(slot, approach, stop);
    if (approach.open()) approach.stop(Termination::interrupted);
    if (approach.asks() == 0) continue;
    OrbitSearchResult looked = co_await look(slot, approach.state(), approach.asks(), options, approach.passed_by());
    approach.answer(std::move(looked.orbit));
  } while (approach.open());
  co_return std::move(approach).result();
}

MotionTask<> average_on_attractor(TaskSlot& slot, const Vector& p, Attractor& attractor, const AttractorOptions& options) {
  slot.set_parameters(p, alone(options));
  LyapunovOptions averaging = options.lyapunov;
  averaging.significance = options.significance;  // also long enough to establish chaos
  if (!is_fast(options)) averaging.motions = std::max(averaging.motions, enough_motions(slot.system(), p, averaging));
  AttractorOptions longer = options;
  for (int round = 0; attractor.termination == Termination::time && attractor.type != AttractorType::periodic; ++round) {
    const bool on = co_await average(slot, round, averaging, options, attractor);
    if (!on || cancelled(options)) co_return;
    longer.transient = longer_transient(longer.transient);
    const Vector from = attractor.state;
    attractor = co_await approach_attractor(slot, p, from, longer);
  }
  if (attractor.termination == Termination::time) average_on_orbit(slot.system(), p, attractor, options);
}

Attractor approach_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out;
  run_alone(system, options.lyapunov.flow,
            [&](TaskSlot& slot) -> MotionTask<> { out = co_await approach_attractor(slot, p, start, options); });
  return out;
}

void average_on_attractor(const HybridSystem& system, const Vector& p, Attractor& attractor, const AttractorOptions& options) {
  run_alone(system, options.lyapunov.flow, [&](TaskSlot& slot) { return average_on_attractor(slot, p, attractor, options); });
}

Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out = approach_attractor(system, p, start, options);
  average_on_attractor(system, p, out, options);
  return out;
}

}  // namespace graze
