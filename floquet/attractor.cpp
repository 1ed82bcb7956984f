// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/approach.hpp>
#include <graze/floquet/rounds.hpp>
#include <graze/floquet/settle.hpp>
#include <graze/floquet/side_by_side.hpp>
#include <graze/lib/in_parallel.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// Chaos is averaged over so many motions side by side, if the budget leaves each of them the longer part of it after parting.
constexpr int motions_in_chaos = 16;
constexpr std::int64_t budget_for_many = 4 * motions_in_chaos * parting;

/// The orbit that is looked for at the end of a transient or an average.
std::optional<PeriodicOrbit> orbit_at_the_end(const HybridSystem& system, const Vector& p, const Vector& state,
                                              const AttractorOptions& options) {
  if (options.recurrence > 0.0)
    return orbit_of_close_returns(system, p, state, options.max_period, nearness_of(options), options.lyapunov.flow);
  return settling_orbit(system, p, state, options.max_period, options.lyapunov.flow);
}

/// Of the motion that was averaged from `begin` on: null where it cannot linger.
std::optional<Lingering> lingering(const HybridSystem& system, const Vector& p, const Vector& begin, const Attractor& attractor,
                                   const AttractorOptions& options) {
  if (attractor.type == AttractorType::periodic || attractor.time_average.stop == LyapunovStop::interrupted ||
      attractor.time_average.termination != Termination::time)
    return std::nullopt;
  const FlowOptions& flow = options.lyapunov.flow;
  const Returns returns = close_returns(system, p, attractor.state, options.max_period, nearness_of(options), flow);
  if (returns.periods.empty()) return std::nullopt;
  Propagator propagator(system, p, {}, flow);
  Lingering watch = watch_end(attractor, returns.periods.front(), forcing_period(system, p), options);
  const auto stop = [&] { return cancelled(options); };
  if (!carry_watched(propagator, watch, stop)) return std::nullopt;
  watch.look_back(begin, periods_each(attractor.time_average));
  if (!carry_watched(propagator, watch, stop)) return std::nullopt;
  return watch;
}

Attractor approach_with_looks(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Approach approach(system, p, start, options);
  Propagator propagator(system, p, {}, options.lyapunov.flow);
  do {
    if (!carry_watched(propagator, approach, [&] { return cancelled(options); })) approach.stop(Termination::interrupted);
    if (approach.asks() > 0)
      approach.answer(
          orbit_of_close_returns(system, p, approach.state(), approach.asks(), nearness_of(options), options.lyapunov.flow));
  } while (approach.open());
  return std::move(approach).result();
}

/// The same, with a look at where its motions ended.
void conclude(const HybridSystem& system, const Vector& p, LyapunovSpectrum average, const AttractorOptions& options,
              Attractor& attractor) {
  // Where it was broken off says nothing: the rest may have come to something else.
  if (average.stop == LyapunovStop::interrupted) return take_average(std::move(average), options, attractor);
  attractor.time_average = std::move(average);
  attractor.state = attractor.time_average.state;
  std::vector<Vector> ends = attractor.time_average.others;
  ends.insert(ends.begin(), attractor.state);
  if (ends.size() > 1) ends = that_may_settle(system, p, ends, options.lyapunov.flow);
  const std::size_t together = options.lyapunov.all_threads ? threads_here() : 1;
  for (std::size_t begin = 0; begin < ends.size(); begin += together) {
    std::vector<std::optional<PeriodicOrbit>> orbits(std::min(together, ends.size() - begin));
    in_parallel(orbits.size(), [&](std::size_t i) { orbits[i] = orbit_at_the_end(system, p, ends[begin + i], options); });
    if (cancelled(options)) {  // not all of them were looked at
      attractor.time_average.stop = LyapunovStop::interrupted;
      break;
    }
    for (auto& orbit : orbits)  // one that has settled tells that the chaos was transient
      if (orbit) return settle_on(attractor, std::move(*orbit));
  }
  take_average(std::move(attractor.time_average), options, attractor);
}

/// Motions side by side are short. Where they have not settled, one is followed for as long as one that is averaged alone.
void look_far_on(const HybridSystem& system, const Vector& p, const AttractorOptions& options, Attractor& attractor) {
  const LyapunovStop stop = attractor.time_average.stop;
  if (attractor.type == AttractorType::periodic || attractor.time_average.others.empty()) return;
  if (stop != LyapunovStop::standard_error && stop != LyapunovStop::budget) return;
  AttractorOptions far = options;
  far.transient = 2000;
  Attractor later = approach_attractor(system, p, attractor.state, far);
  if (later.termination == Termination::interrupted) attractor.time_average.stop = LyapunovStop::interrupted;
  if (later.orbit) settle_on(attractor, std::move(*later.orbit));
}

}  // namespace

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

void settle_on(Attractor& attractor, PeriodicOrbit orbit) {
  attractor.type = AttractorType::periodic;
  attractor.termination = Termination::time;
  attractor.period = orbit.period;
  attractor.impacts = orbit.impacts;
  attractor.state = orbit.state;
  attractor.exponents = orbit.multipliers.exponents;
  attractor.standard_errors.assign(attractor.exponents.size(), 0.0);
  attractor.orbit = std::move(orbit);
}

Attractor approach_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  if (options.recurrence > 0.0) return approach_with_looks(system, p, start, options);
  Attractor out;
  SettleOptions settling;
  settling.periods = options.transient;
  settling.max_period = 0;
  settling.cancelled = options.lyapunov.cancelled;
  settling.flow = options.lyapunov.flow;
  const Settled settled = settle(system, p, start, settling);
  out.termination = settled.termination;
  out.state = settled.state;
  if (out.termination != Termination::time) return out;
  if (auto orbit = orbit_at_the_end(system, p, out.state, options)) settle_on(out, std::move(*orbit));
  return out;
}

void average_on_attractor(const HybridSystem& system, const Vector& p, Attractor& attractor, const AttractorOptions& options) {
  if (attractor.termination != Termination::time) return;
  LyapunovOptions averaging = options.lyapunov;
  if (attractor.type == AttractorType::periodic) {
    averaging.max_periods = std::min<std::int64_t>(averaging.max_periods, options.periods_on_orbit);
    if (averaging.max_periods >= averaging.interval)
      attractor.time_average = lyapunov_spectrum(system, p, attractor.state, averaging);
    return;
  }
  averaging.significance = options.significance;  // long enough to tell chaos, too
  if (averaging.change == 0.0 && averaging.max_periods >= budget_for_many)
    averaging.motions = std::max(averaging.motions, motions_in_chaos);
  AttractorOptions longer = options;
  for (int round = 0;; ++round) {
    const Vector begin = attractor.state;
    conclude(system, p, lyapunov_spectrum(system, p, begin, averaging), options, attractor);
    if (wants_confirmation(options, attractor))
      conclude(system, p, lyapunov_spectrum(system, p, attractor.state, averaging), options, attractor);
    look_far_on(system, p, options, attractor);
    const std::optional<Lingering> watch = lingering(system, p, begin, attractor, options);
    LyapunovStop& stop = attractor.time_average.stop;
    const bool open = attractor.type != AttractorType::periodic && stop != LyapunovStop::interrupted;
    if (open && cancelled(options)) stop = LyapunovStop::interrupted;  // it may go on
    if (!watch || !watch->goes_on()) return;
    if (round == most_rounds) {
      if (watch->always()) attractor.type = AttractorType::undecided;
      return;
    }
    if (watch->on_an_orbit()) push_off(system, p, round, attractor.state);
    longer.transient = longer_transient(longer.transient);
    attractor = approach_attractor(system, p, attractor.state, longer);
    if (attractor.type == AttractorType::periodic || attractor.termination != Termination::time)
      return average_on_attractor(system, p, attractor, options);
  }
}

Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out = approach_attractor(system, p, start, options);
  average_on_attractor(system, p, out, options);
  return out;
}

}  // namespace graze
