// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor.hpp>
#include <graze/floquet/lyapunov_lanes.hpp>
#include <graze/floquet/settle.hpp>
#include <graze/floquet/side_by_side.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// Chaos is averaged over so many motions side by side, if the budget leaves each of them the longer part of it after parting.
constexpr int motions_in_chaos = 16;
constexpr std::int64_t budget_for_many = 4 * motions_in_chaos * parting;

/// Where AttractorOptions::recurrence is set: returns that are worth Newton's method, against those that give rise to a look.
double nearness_of(const AttractorOptions& options) { return 20.0 * options.recurrence; }

bool cancelled(const AttractorOptions& options) { return options.lyapunov.cancelled && options.lyapunov.cancelled(); }

/// The orbit that is looked for at the end of a transient or an average.
std::optional<PeriodicOrbit> orbit_at_the_end(const HybridSystem& system, const Vector& p, const Vector& state,
                                              const AttractorOptions& options) {
  if (options.recurrence > 0.0)
    return orbit_of_close_returns(system, p, state, options.max_period, nearness_of(options), options.lyapunov.flow);
  return settling_orbit(system, p, state, options.max_period, options.lyapunov.flow);
}

/// Whether the motion repeats itself, nearly and for long, without being known as periodic: it leaves a weakly unstable orbit, or
/// comes to a weakly stable one, and its average says nothing of where it ends. Chaos that happens to come back is soon away.
bool lingers(const HybridSystem& system, const Vector& p, const Attractor& attractor, const AttractorOptions& options) {
  if (attractor.type == AttractorType::periodic || attractor.termination != Termination::time) return false;
  constexpr int long_enough = 128;
  const FlowOptions& flow = options.lyapunov.flow;
  const double nearness = nearness_of(options);
  const Returns returns = close_returns(system, p, attractor.state, options.max_period, nearness, flow);
  if (returns.periods.empty()) return false;
  const auto n = static_cast<std::size_t>(returns.periods.front());
  Propagator propagator(system, p, {}, flow);
  Transition transition;
  std::vector<Vector> states(returns.states.begin(), returns.states.begin() + returns.periods.front() + 1);
  const double T = forcing_period(system, p), scale = 1.0 + attractor.state.lpNorm<Eigen::Infinity>();
  for (int k = 0; k < long_enough; ++k) {
    carry(propagator, 0.0, T, states.back(), {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination != Termination::time) return false;
    states.push_back(transition.x1);
    if ((states.back() - states[states.size() - 1 - n]).lpNorm<Eigen::Infinity>() > nearness * scale) return false;
  }
  return true;
}

/// A transient on its way, with a look at its returns.
class Approach {
 public:
  Approach(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options)
      : system_(system), p_(p), options_(options), watch_(options.recurrence) {
    initial_mode(system, 0.0, start, p);
    out_.state = start;
    out_.termination = Termination::time;
  }

  bool open() const { return open_ && periods_ < options_.transient; }
  const Vector& state() const { return out_.state; }
  void stop(Termination reason) {
    out_.termination = reason;
    open_ = false;
  }

  /// What one more period did.
  void see(Termination termination, const Vector& state) {
    ++periods_;
    if (termination != Termination::time) return stop(termination);
    out_.state = state;
    const int back = watch_.see(state);
    if (back == 0) return;
    if (auto orbit = orbit_of_close_returns(system_, p_, state, std::min(back, options_.max_period), nearness_of(options_),
                                            options_.lyapunov.flow)) {
      settle_on(out_, std::move(*orbit));
      open_ = false;
    }
  }

  Attractor result() && {
    if (open_)
      if (auto orbit = orbit_at_the_end(system_, p_, out_.state, options_)) settle_on(out_, std::move(*orbit));
    return std::move(out_);
  }

 private:
  const HybridSystem& system_;
  const Vector& p_;
  const AttractorOptions& options_;
  ReturnWatch watch_;
  Attractor out_;
  int periods_ = 0;
  bool open_ = true;
};

Attractor approach_with_looks(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Approach approach(system, p, start, options);
  Propagator propagator(system, p, {}, options.lyapunov.flow);
  if (!carry_watched(propagator, approach, [&] { return cancelled(options); })) approach.stop(Termination::interrupted);
  return std::move(approach).result();
}

/// All transients side by side.
std::vector<Attractor> approach_each(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                     const AttractorOptions& options) {
  ManyMotions many(system, options.lyapunov.flow);
  std::vector<Approach> approaches;
  std::vector<std::size_t> sets;
  for (const AverageStart& start : starts) {
    approaches.emplace_back(system, start.p, start.state, options);
    sets.push_back(many.add_parameters(start.p));
  }
  if (!carry_side_by_side(many, sets, approaches, [&] { return cancelled(options); }))
    for (Approach& approach : approaches)
      if (approach.open()) approach.stop(Termination::interrupted);
  std::vector<Attractor> out;
  for (Approach& approach : approaches) out.push_back(std::move(approach).result());
  return out;
}

/// What the time average over a motion that was not known to be periodic says.
void conclude(const HybridSystem& system, const Vector& p, LyapunovSpectrum average, const AttractorOptions& options,
              Attractor& attractor) {
  attractor.time_average = std::move(average);
  attractor.state = attractor.time_average.state;
  std::vector<Vector> ends = attractor.time_average.others;
  ends.insert(ends.begin(), attractor.state);
  for (const Vector& end : ends) {  // one that has settled tells that the chaos was transient
    if (auto orbit = orbit_at_the_end(system, p, end, options)) return settle_on(attractor, std::move(*orbit));
    if (cancelled(options)) return;
  }
  attractor.exponents = attractor.time_average.exponents;
  attractor.standard_errors = attractor.time_average.standard_errors;
  if (!attractor.exponents.empty() && attractor.exponents[0] > options.significance * attractor.standard_errors[0])
    attractor.type = AttractorType::chaotic;
}

/// Goes on from an attractor that lingers.
void go_on(const HybridSystem& system, const Vector& p, const AttractorOptions& options, Attractor& out) {
  AttractorOptions longer = options;
  constexpr int most_rounds = 3;
  for (int round = 0; lingers(system, p, out, options); ++round) {
    if (round == most_rounds) {
      out.type = AttractorType::undecided;
      break;
    }
    longer.transient = 3 * std::max(1, longer.transient);
    out = approach_attractor(system, p, out.state, longer);
    average_on_attractor(system, p, out, longer);
  }
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
  conclude(system, p, lyapunov_spectrum(system, p, attractor.state, averaging), options, attractor);
}

Attractor find_attractor(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options) {
  Attractor out = approach_attractor(system, p, start, options);
  average_on_attractor(system, p, out, options);
  if (options.recurrence > 0.0) go_on(system, p, options, out);
  return out;
}

std::vector<Attractor> find_each_attractor(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                           const AttractorOptions& options) {
  const bool side_by_side = options.recurrence > 0.0 && options.periods_on_orbit == 0 &&
                            std::all_of(starts.begin(), starts.end(), [&](const auto& start) {
                              return ManyMotions::applies(system, start.p, options.lyapunov.flow);
                            });
  std::vector<Attractor> out;
  if (!side_by_side) {
    for (const AverageStart& start : starts) out.push_back(find_attractor(system, start.p, start.state, options));
    return out;
  }
  out = approach_each(system, starts, options);
  std::vector<std::size_t> open;
  std::vector<AverageStart> averaged;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (out[i].termination != Termination::time || out[i].type == AttractorType::periodic) continue;
    open.push_back(i);
    averaged.push_back({starts[i].p, out[i].state});
  }
  LyapunovOptions averaging = options.lyapunov;
  averaging.significance = options.significance;
  std::vector<LyapunovSpectrum> averages = lane_spectra(system, averaged, averaging);
  for (std::size_t k = 0; k < open.size(); ++k) {
    const std::size_t i = open[k];
    conclude(system, starts[i].p, std::move(averages[k]), options, out[i]);
    go_on(system, starts[i].p, options, out[i]);
  }
  return out;
}

}  // namespace graze
