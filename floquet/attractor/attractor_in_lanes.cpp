// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor_decision.hpp>
#include <graze/floquet/attractor/attractor_in_lanes.hpp>
#include <graze/floquet/attractor/refused_orbits.hpp>
#include <graze/floquet/attractor/transient.hpp>
#include <graze/floquet/exponents/lyapunov_lanes.hpp>
#include <graze/floquet/orbit/observe.hpp>

namespace graze {

namespace {

/// Periods after which a running average is checked for a motion that has settled; the interval then doubles.
constexpr std::int64_t first_check_of_average = 2000;

/// Cancellation test, called before forcing periods are carried.
struct Stop {
  const AttractorOptions& options;
  bool operator()() const { return cancelled(options); }
};

MotionTask<OrbitSearchResult> look(TaskSlot& lane, const HybridSystem& system, const Vector& p, const Vector& state, int most,
                                   const AttractorOptions& options, RefusedOrbits* refused = nullptr) {
  return look_for_orbit_in_lanes(lane, system, p, state, most, return_tolerance(options), options.lyapunov.flow, refused);
}

/// approach_attractor in the lanes.
MotionTask<Attractor> approach(TaskSlot& lane, const HybridSystem& system, const Vector& p, const Vector& start,
                               const AttractorOptions& options) {
  const Stop stop{options};
  Transient approach(system, p, start, options);
  do {
    co_await carry_watched(lane, approach, stop);
    if (approach.open()) approach.stop(Termination::interrupted);
    if (approach.asks() == 0) continue;
    OrbitSearchResult looked = co_await look(lane, system, p, approach.state(), approach.asks(), options, approach.passed_by());
    approach.answer(std::move(looked.orbit));
  } while (approach.open());
  co_return std::move(approach).result();
}

/// Averages a motion that is not known to be periodic. Returns whether it must be continued from its new state.
MotionTask<bool> average(TaskSlot& lane, const HybridSystem& system, const Vector& p, int round, const AttractorOptions& options,
                         Attractor& attractor) {
  const Stop stop{options};
  const Vector begin = attractor.state;
  LyapunovOptions averaging = options.lyapunov;
  averaging.significance = options.significance;
  for (bool again = false;; again = true) {
    const AverageStart start{p, attractor.state};
    LaneAverage average(lane, system, start, averaging);
    RefusedOrbits refused;
    for (std::int64_t periods = first_check_of_average;; periods *= 2) {
      const bool open = co_await average.carry(lane, periods);
      if (!open) break;
      OrbitSearchResult looked =
          co_await look(lane, system, p, average.state(), longest_period_tried(options, periods), options, &refused);
      if (!looked.orbit) continue;
      settle_on(attractor, std::move(*looked.orbit));
      co_return false;
    }
    evaluate_average(std::move(average).result(), options, attractor);
    if (again || !needs_confirmation(options, attractor)) break;
  }
  if (stop()) co_return false;  // an interrupted average means nothing
  const int periods = longest_period_tried(options, attractor.time_average.periods_each());
  OrbitSearchResult looked = co_await look(lane, system, p, attractor.state, periods, options);
  if (looked.orbit) {
    settle_on(attractor, std::move(*looked.orbit));
    co_return false;
  }
  const double T = forcing_period(system, p);
  if (looked.closest > 0 && may_be_laminar(attractor, round, T)) {
    LaminarPhase watch = laminar_watch(attractor, looked.closest, T, options);
    co_await carry_watched(lane, watch, stop);
    if (stop()) co_return false;
    watch.look_back(begin, attractor.time_average.periods_each());
    co_await carry_watched(lane, watch, stop);
    if (stop()) co_return false;
    if (goes_on(watch, system, p, round, attractor)) co_return true;
  }
  const bool too_short = attractor.type == AttractorType::undecided && !attractor.conservative && round < rounds_for_undecided;
  co_return too_short;
}

/// Whether the lanes support the oscillator and the options.
bool lanes_apply(const HybridSystem& system, const Vector& p, const AttractorOptions& options) {
  return options.recurrence > 0.0 && options.periods_on_orbit == 0 && LaneCarrier::applies(system, p, options.lyapunov.flow);
}

MotionTask<> find_into(TaskSlot& lane, const HybridSystem& system, const AverageStart& start, const AttractorOptions& options,
                       Attractor& attractor) {
  attractor = co_await approach_attractor_in_lanes(lane, system, start.p, start.state, options);
  co_await average_on_attractor_in_lanes(lane, system, start.p, attractor, options);
}

}  // namespace

MotionTask<Attractor> approach_attractor_in_lanes(TaskSlot& lane, const HybridSystem& system, const Vector& p,
                                                  const Vector& start, const AttractorOptions& options) {
  if (!lanes_apply(system, p, options)) {
    Attractor alone = approach_attractor(system, p, start, options);
    co_return alone;
  }
  lane.set_parameters(p);
  Attractor attractor = co_await approach(lane, system, p, start, options);
  co_return attractor;
}

MotionTask<> average_on_attractor_in_lanes(TaskSlot& lane, const HybridSystem& system, const Vector& p, Attractor& attractor,
                                           const AttractorOptions& options) {
  if (!lanes_apply(system, p, options)) {
    average_on_attractor(system, p, attractor, options);
    co_return;
  }
  lane.set_parameters(p);
  AttractorOptions longer = options;
  for (int round = 0; attractor.termination == Termination::time && attractor.type != AttractorType::periodic; ++round) {
    const bool on = co_await average(lane, system, p, round, options, attractor);
    if (!on || cancelled(options)) break;
    longer.transient = longer_transient(longer.transient);
    const Vector from = attractor.state;
    attractor = co_await approach(lane, system, p, from, longer);
  }
}

std::vector<Attractor> find_each_attractor(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                           const AttractorOptions& options) {
  std::vector<Attractor> out(starts.size());
  LaneCarrier many(system, options.lyapunov.flow);
  TaskPool pool(many);
  pool.run(starts.size(), [&](std::size_t i, TaskSlot& lane) { return find_into(lane, system, starts[i], options, out[i]); });
  return out;
}

}  // namespace graze
