// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor_decision.hpp>
#include <graze/floquet/attractor/transient.hpp>
#include <graze/floquet/exponents/lyapunov_lanes.hpp>
#include <graze/floquet/orbit/observe.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <algorithm>
#include <functional>
#include <numbers>

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

void describe_orbit(Attractor& attractor, const PeriodicOrbit& orbit) {
  attractor.type = AttractorType::periodic;
  attractor.termination = Termination::time;
  attractor.period = orbit.period;
  attractor.impacts = orbit.impacts;
  attractor.isolated_impacts = orbit.isolated_impacts;
  attractor.rests = orbit.rests;
  attractor.conservative = orbit.conservative;
  attractor.motion = orbit.neutral() ? ConservativeMotion::neutral : ConservativeMotion::unknown;
  attractor.state = orbit.state;
  attractor.multipliers = orbit.multipliers.values;
  attractor.exponents = orbit.multipliers.exponents;
  if (orbit.multipliers.section == Section::autonomous) {
    attractor.duration = orbit.duration;
    std::fill(attractor.exponents.end() - orbit.multipliers.trivial, attractor.exponents.end(), 0.0);
    std::stable_sort(attractor.exponents.begin(), attractor.exponents.end(), std::greater<>());  // the trivial one comes last
  }
  attractor.standard_errors.assign(attractor.exponents.size(), 0.0);
  attractor.orbit.reset();
}

void settle_on(Attractor& attractor, PeriodicOrbit orbit) {
  describe_orbit(attractor, orbit);
  attractor.orbit = std::make_shared<const PeriodicOrbit>(std::move(orbit));
}

Attractor approach_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Transient approach(system, p, start, options);
  Propagator propagator(system, p, {}, options.lyapunov.flow);
  do {
    if (!carry_watched(propagator, approach, [&] { return cancelled(options); })) approach.stop(Termination::interrupted);
    if (approach.asks() > 0)
      approach.answer(look_for_orbit(propagator, approach.state(), approach.asks(), options, approach.passed_by()));
  } while (approach.open());
  return std::move(approach).result();
}

Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out = approach_attractor(system, p, start, options);
  average_on_attractor(system, p, out, options);
  return out;
}

namespace {

/// Number of chaotic motions averaged in parallel. It fills the lanes of one thread, provided that most of each motion's budget
/// remains after parting. It grows up to the lanes of several threads if each motion lasts for at least ten times `parting`.
constexpr std::int64_t motions_of_a_thread = 16, most_motions = 128;
constexpr std::int64_t budget_for_many = 4 * motions_of_a_thread * decorrelation_periods;

/// Expected length of an average: its budget, or the periods after which the standard error reaches its bound. (The growth per
/// period has a standard deviation of about 1/3, and a period is about 2 pi long.)
std::int64_t expected_periods(const LyapunovOptions& averaging) {
  const double per_error = 3.0 * averaging.standard_error * 2.0 * std::numbers::pi;
  return static_cast<std::int64_t>(
      std::min(static_cast<double>(averaging.max_periods), per_error > 0.0 ? 1.0 / (per_error * per_error) : 1e18));
}
}  // namespace

int motions_in_chaos(const LyapunovOptions& averaging) {
  if (averaging.change > 0.0 || averaging.max_periods < budget_for_many) return 1;
  const std::int64_t wanted = expected_periods(averaging) / (10 * decorrelation_periods);
  return static_cast<int>(std::clamp(wanted / motions_of_a_thread * motions_of_a_thread, motions_of_a_thread, most_motions));
}

int motions_in_shared_lanes(const LyapunovOptions& averaging) {
  const int alone = motions_in_chaos(averaging);
  return expected_periods(averaging) < 4 * decorrelation_periods * alone ? 1 : alone;
}

namespace {

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
  LaneCarrier many(system, averaging.flow);
  if (averaging.all_threads) many.use_all_threads();
  const std::size_t set = many.add_parameters(p);
  std::vector<MotionStart> starts;
  for (const Vector& state : states) starts.push_back({set, state[0], state[1]});
  const auto periods = static_cast<std::size_t>(std::max(1, in_all / averaging.motions));
  std::vector<PeriodResult> results;
  many.carry(starts, periods, false, results);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const PeriodResult& end = results[(k + 1) * periods - 1];
    if (end.termination == Termination::time) states[k] << end.x, end.v;
  }
  return states;
}

/// Takes a time average, looks for an orbit from the final states of its motions, and evaluates it.
void average(const HybridSystem& system, const Vector& p, Attractor& attractor, const LyapunovOptions& averaging,
             const AttractorOptions& options) {
  LyapunovSpectrum average = lyapunov_spectrum(system, p, attractor.state, averaging);
  if (average.termination == Termination::no_return) {
    attractor.termination = Termination::no_return;
    attractor.state = average.state;
    attractor.time_average = std::move(average);
    return;
  }
  // The state at an interruption means nothing: the remaining periods might have led elsewhere.
  if (average.stop == LyapunovStop::interrupted) return evaluate_average(std::move(average), options, attractor);
  std::vector<Vector> ends = continued_states(system, p, average, averaging);
  attractor.time_average = std::move(average);
  attractor.state = attractor.time_average.state;
  if (ends.size() > 1) ends = settling_candidates(system, p, ends, options.lyapunov.flow);
  const int most = longest_period_tried(options, attractor.time_average.periods_each());
  const std::size_t together = options.lyapunov.all_threads ? available_threads() : 1;
  for (std::size_t begin = 0; begin < ends.size(); begin += together) {
    std::vector<std::optional<PeriodicOrbit>> orbits(std::min(together, ends.size() - begin));
    in_parallel(orbits.size(), [&](std::size_t i) {
      Propagator propagator(system, p, {}, options.lyapunov.flow);
      orbits[i] = look_for_orbit(propagator, ends[begin + i], most, options);
    });
    if (cancelled(options)) {  // not all of them were tried
      attractor.time_average.stop = LyapunovStop::interrupted;
      break;
    }
    for (auto& orbit : orbits)  // one settled motion proves that the chaos was transient
      if (orbit) return settle_on(attractor, std::move(*orbit));
  }
  evaluate_average(std::move(attractor.time_average), options, attractor);
}

/// Laminar phase of the motion that was averaged from `begin` on. Null if there cannot be one.
std::optional<LaminarPhase> lingering(const HybridSystem& system, const Vector& p, const Vector& begin, int round,
                                      const Attractor& attractor, const AttractorOptions& options) {
  const double T = period_time(system, p, attractor.time_average);
  if (attractor.type == AttractorType::periodic || attractor.time_average.stop == LyapunovStop::interrupted ||
      attractor.time_average.termination != Termination::time || !may_be_laminar(attractor, round, T))
    return std::nullopt;
  Propagator propagator(system, p, {}, options.lyapunov.flow);
  const int most = longest_period_tried(options, attractor.time_average.periods_each());
  const Returns returns = close_returns(propagator, attractor.state, most, return_tolerance(options));
  if (returns.periods.empty()) return std::nullopt;
  LaminarPhase watch = laminar_watch(attractor, returns.periods.front(), T, options);
  const auto stop = [&] { return cancelled(options); };
  if (!carry_watched(propagator, watch, stop)) return std::nullopt;
  watch.look_back(begin, attractor.time_average.periods_each());
  if (!carry_watched(propagator, watch, stop)) return std::nullopt;
  return watch;
}

/// Whether the motion that was averaged from `begin` on must be continued.
bool goes_on(const HybridSystem& system, const Vector& p, const Vector& begin, int round, const AttractorOptions& options,
             Attractor& attractor) {
  const std::optional<LaminarPhase> watch = lingering(system, p, begin, round, attractor, options);
  LyapunovStop& stop = attractor.time_average.stop;
  const bool open = attractor.type != AttractorType::periodic && stop != LyapunovStop::interrupted;
  if (open && cancelled(options)) stop = LyapunovStop::interrupted;  // it may have to be continued
  return watch && goes_on(*watch, system, p, round, attractor);
}

}  // namespace

void average_on_attractor(const HybridSystem& system, const Vector& p, Attractor& attractor, const AttractorOptions& options) {
  LyapunovOptions averaging = options.lyapunov;
  averaging.significance = options.significance;  // also long enough to establish chaos
  averaging.motions = std::max(averaging.motions, motions_in_chaos(averaging));
  AttractorOptions longer = options;
  for (int round = 0; attractor.termination == Termination::time && attractor.type != AttractorType::periodic; ++round) {
    const Vector begin = attractor.state;
    average(system, p, attractor, averaging, options);
    if (needs_confirmation(options, attractor)) average(system, p, attractor, averaging, options);
    if (!goes_on(system, p, begin, round, options, attractor)) return;
    longer.transient = longer_transient(longer.transient);
    attractor = approach_attractor(system, p, attractor.state, longer);
  }
  if (attractor.termination == Termination::time) average_on_orbit(system, p, attractor, options);
}

}  // namespace graze
