// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor.hpp>
#include <graze/floquet/lingering.hpp>
#include <graze/floquet/lyapunov_lanes.hpp>
#include <graze/floquet/settle.hpp>
#include <graze/floquet/side_by_side.hpp>
#include <graze/lib/in_parallel.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace graze {

namespace {

/// Chaos is averaged over so many motions side by side, if the budget leaves each of them the longer part of it after parting.
constexpr int motions_in_chaos = 16;
constexpr std::int64_t budget_for_many = 4 * motions_in_chaos * parting;

/// Where AttractorOptions::recurrence is set: returns that are worth Newton's method, against those that give rise to a look. And
/// how nearly a motion that lingers repeats itself.
double nearness_of(const AttractorOptions& options) { return 20.0 * (options.recurrence > 0.0 ? options.recurrence : 1e-4); }

bool cancelled(const AttractorOptions& options) { return options.lyapunov.cancelled && options.lyapunov.cancelled(); }

/// The orbit that is looked for at the end of a transient or an average.
std::optional<PeriodicOrbit> orbit_at_the_end(const HybridSystem& system, const Vector& p, const Vector& state,
                                              const AttractorOptions& options) {
  if (options.recurrence > 0.0)
    return orbit_of_close_returns(system, p, state, options.max_period, nearness_of(options), options.lyapunov.flow);
  return settling_orbit(system, p, state, options.max_period, options.lyapunov.flow);
}

/// A motion that lingers is given transients three times as long, then nine times, ...
constexpr int most_rounds = 3, shortest_transient = 300;

/// Off an unstable orbit that it is on, farther each time; not into a barrier.
void push_off(const HybridSystem& system, const Vector& p, int round, Vector& state) {
  const double far = 1e-4 * std::pow(10.0, round) * (1.0 + state.lpNorm<Eigen::Infinity>());
  for (const double way : {-far, far}) {
    Vector pushed = state;
    pushed[0] += way;
    if (system.initial_mode && !system.initial_mode(0.0, pushed, p)) continue;
    state = pushed;
    return;
  }
}

/// The periods that each of the motions of an average was carried.
std::int64_t length(const LyapunovSpectrum& average) {
  return average.periods / static_cast<std::int64_t>(1 + average.others.size());
}

/// A watch on the end of an average. A distance as small as rounding grows beyond all bounds in 40 times the time in which the
/// exponent has it grow e-fold.
Lingering watch_end(const Attractor& attractor, int period, double T, const AttractorOptions& options) {
  constexpr double most = 20000.0;
  const double growth = attractor.type == AttractorType::chaotic ? attractor.exponents[0] * T : 0.0;
  const bool can_tell = growth * most > 40.0;
  return {attractor.state, period, nearness_of(options), can_tell ? static_cast<std::int64_t>(40.0 / growth) : 0};
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
  watch.look_back(begin, length(attractor.time_average));
  if (!carry_watched(propagator, watch, stop)) return std::nullopt;
  return watch;
}

/// A transient on its way, with a look at its returns.
class Approach {
 public:
  Approach(const HybridSystem& system, const Vector& p, const Vector& start, const AttractorOptions& options)
      : options_(options), watch_(options.recurrence) {
    initial_mode(system, 0.0, start, p);
    out_.state = start;
    out_.termination = Termination::time;
    if (options.transient == 0) asks_ = options.max_period;
  }

  bool open() const { return open_ && asks_ == 0; }
  const Vector& state() const { return out_.state; }
  void stop(Termination reason) {
    out_.termination = reason;
    open_ = false;
    asks_ = 0;
  }

  /// What one more period did.
  void see(Termination termination, const Vector& state) {
    ++periods_;
    if (termination != Termination::time) return stop(termination);
    out_.state = state;
    asks_ = std::min(watch_.see(state), options_.max_period);
    if (periods_ == options_.transient) asks_ = options_.max_period;
  }

  /// > 0: it goes on when it is told whether it is settling on an orbit of up to so many periods.
  int asks() const { return asks_; }
  void answer(std::optional<PeriodicOrbit> orbit) {
    open_ = !orbit && periods_ < options_.transient;
    asks_ = 0;
    if (orbit) settle_on(out_, std::move(*orbit));
  }

  Attractor result() && { return std::move(out_); }

 private:
  const AttractorOptions& options_;
  ReturnWatch watch_;
  Attractor out_;
  int periods_ = 0, asks_ = 0;
  bool open_ = true;
};

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

/// What the time average over a motion that was not known to be periodic says, if it has not settled.
void take_average(LyapunovSpectrum average, const AttractorOptions& options, Attractor& attractor) {
  attractor.time_average = std::move(average);
  attractor.state = attractor.time_average.state;
  attractor.exponents = attractor.time_average.exponents;
  attractor.standard_errors = attractor.time_average.standard_errors;
  const bool positive =
      !attractor.exponents.empty() && attractor.exponents[0] > options.significance * attractor.standard_errors[0];
  attractor.type = positive ? AttractorType::chaotic : AttractorType::undecided;
}

/// Many looks at an average find it positive by chance, or for a while: where one stopped as soon as it was, another has to say
/// the same.
bool wants_confirmation(const AttractorOptions& options, const Attractor& attractor) {
  return options.recurrence > 0.0 && attractor.type == AttractorType::chaotic &&
         attractor.time_average.stop == LyapunovStop::standard_error;
}

/// The same, with a look at where its motions ended.
void conclude(const HybridSystem& system, const Vector& p, LyapunovSpectrum average, const AttractorOptions& options,
              Attractor& attractor) {
  attractor.time_average = std::move(average);
  attractor.state = attractor.time_average.state;
  std::vector<Vector> ends = attractor.time_average.others;
  ends.insert(ends.begin(), attractor.state);
  if (ends.size() > 1) ends = that_may_settle(system, p, ends, options.lyapunov.flow);
  const std::size_t together = options.lyapunov.all_threads ? threads_here() : 1;
  for (std::size_t begin = 0; begin < ends.size(); begin += together) {
    std::vector<std::optional<PeriodicOrbit>> orbits(std::min(together, ends.size() - begin));
    in_parallel(orbits.size(), [&](std::size_t i) { orbits[i] = orbit_at_the_end(system, p, ends[begin + i], options); });
    for (auto& orbit : orbits)  // one that has settled tells that the chaos was transient
      if (orbit) return settle_on(attractor, std::move(*orbit));
    if (cancelled(options)) {  // not all of them were looked at
      attractor.time_average.stop = LyapunovStop::interrupted;
      break;
    }
  }
  take_average(std::move(attractor.time_average), options, attractor);
}

/// find_attractor from many starts in lanes.
class SideBySide {
 public:
  SideBySide(const HybridSystem& system, const std::vector<AverageStart>& starts, const AttractorOptions& options)
      : system_(system), starts_(starts), options_(options), many_(system, options.lyapunov.flow), out_(starts.size()) {
    for (const AverageStart& start : starts) sets_.push_back(many_.add_parameters(start.p));
  }

  std::vector<Attractor> find() {
    std::vector<std::size_t> all(starts_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    for (std::size_t i : all) out_[i].state = starts_[i].state;
    std::vector<std::size_t> left = find(all, 0, options_);
    AttractorOptions longer = options_;
    for (int round = 1; !left.empty(); ++round) {
      longer.transient = 3 * std::max(longer.transient, shortest_transient);
      left = find(left, round, longer);
    }
    return std::move(out_);
  }

 private:
  bool unsettled(std::size_t i) const {
    return out_[i].termination == Termination::time && out_[i].type != AttractorType::periodic;
  }

  /// From where they are. Returns those that linger.
  std::vector<std::size_t> find(const std::vector<std::size_t>& which, int round, const AttractorOptions& options) {
    approach(which, options);
    std::vector<std::size_t> open, repeating;
    std::copy_if(which.begin(), which.end(), std::back_inserter(open), [&](std::size_t i) { return unsettled(i); });
    std::vector<Vector> begin;
    for (const std::size_t i : open) begin.push_back(out_[i].state);
    average(open, options);
    confirm(open, options);
    const std::vector<SettlingLook> looks = look(open, std::vector(open.size(), options.max_period));
    std::vector<Lingering> watches;
    std::vector<std::size_t> sets;
    for (std::size_t k = 0; k < open.size(); ++k) {
      Attractor& attractor = out_[open[k]];
      if (looks[k].orbit) settle_on(attractor, *looks[k].orbit);
      if (looks[k].orbit || looks[k].closest == 0) continue;
      watches.push_back(watch_end(attractor, looks[k].closest, forcing_period(system_, starts_[open[k]].p), options));
      sets.push_back(sets_[open[k]]);
      repeating.push_back(k);
    }
    const auto stop = [&] { return cancelled(options); };
    if (!carry_side_by_side(many_, sets, watches, stop)) return {};
    for (std::size_t k = 0; k < repeating.size(); ++k)
      watches[k].look_back(begin[repeating[k]], length(out_[open[repeating[k]]].time_average));
    if (!carry_side_by_side(many_, sets, watches, stop)) return {};
    std::vector<std::size_t> lingering;
    for (std::size_t k = 0; k < repeating.size(); ++k) {
      if (!watches[k].goes_on()) continue;
      const std::size_t i = open[repeating[k]];
      if (round == most_rounds) {
        if (watches[k].always()) out_[i].type = AttractorType::undecided;
        continue;
      }
      lingering.push_back(i);
      if (watches[k].on_an_orbit()) push_off(system_, starts_[i].p, round, out_[i].state);
    }
    return lingering;
  }

  void approach(const std::vector<std::size_t>& which, const AttractorOptions& options) {
    std::vector<Approach> approaches;
    std::vector<std::size_t> sets;
    for (const std::size_t i : which) {
      approaches.emplace_back(system_, starts_[i].p, Vector(out_[i].state), options);
      sets.push_back(sets_[i]);
    }
    std::vector<std::size_t> asking;
    do {
      if (!carry_side_by_side(many_, sets, approaches, [&] { return cancelled(options); }))
        for (Approach& approach : approaches)
          if (approach.open()) approach.stop(Termination::interrupted);
      std::vector<int> most;
      asking.clear();
      for (std::size_t k = 0; k < which.size(); ++k) {
        if (approaches[k].asks() == 0) continue;
        asking.push_back(k);
        most.push_back(approaches[k].asks());
      }
      std::vector<std::size_t> who;
      for (const std::size_t k : asking) {
        who.push_back(which[k]);
        out_[which[k]].state = approaches[k].state();
      }
      std::vector<SettlingLook> looks = look(who, most);
      for (std::size_t k = 0; k < asking.size(); ++k) approaches[asking[k]].answer(std::move(looks[k].orbit));
    } while (!asking.empty());
    for (std::size_t k = 0; k < which.size(); ++k) out_[which[k]] = std::move(approaches[k]).result();
  }

  void average(const std::vector<std::size_t>& which, const AttractorOptions& options) {
    std::vector<AverageStart> starts;
    for (const std::size_t i : which) starts.push_back({starts_[i].p, out_[i].state});
    LyapunovOptions averaging = options.lyapunov;
    averaging.significance = options.significance;
    std::vector<LyapunovSpectrum> averages = lane_spectra(system_, starts, averaging);
    for (std::size_t k = 0; k < which.size(); ++k) take_average(std::move(averages[k]), options, out_[which[k]]);
  }

  void confirm(std::vector<std::size_t> which, const AttractorOptions& options) {
    std::erase_if(which, [&](std::size_t i) { return !wants_confirmation(options, out_[i]); });
    average(which, options);
  }

  /// Whether those motions are settling on orbits.
  std::vector<SettlingLook> look(const std::vector<std::size_t>& which, const std::vector<int>& most) {
    std::vector<SettlingMotion> motions;
    for (std::size_t k = 0; k < which.size(); ++k)
      motions.push_back({sets_[which[k]], starts_[which[k]].p, out_[which[k]].state, most[k]});
    return look_for_orbits(system_, many_, motions, nearness_of(options_), options_.lyapunov.flow);
  }

  const HybridSystem& system_;
  const std::vector<AverageStart>& starts_;
  const AttractorOptions& options_;
  ManyMotions many_;
  std::vector<std::size_t> sets_;
  std::vector<Attractor> out_;
};

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
    const std::optional<Lingering> watch = lingering(system, p, begin, attractor, options);
    if (!watch || !watch->goes_on()) return;
    if (round == most_rounds) {
      if (watch->always()) attractor.type = AttractorType::undecided;
      return;
    }
    if (watch->on_an_orbit()) push_off(system, p, round, attractor.state);
    longer.transient = 3 * std::max(longer.transient, shortest_transient);
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

std::vector<Attractor> find_each_attractor(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                           const AttractorOptions& options) {
  const bool side_by_side = options.recurrence > 0.0 && options.periods_on_orbit == 0 &&
                            std::all_of(starts.begin(), starts.end(), [&](const auto& start) {
                              return ManyMotions::applies(system, start.p, options.lyapunov.flow);
                            });
  if (side_by_side) return SideBySide(system, starts, options).find();
  std::vector<Attractor> out;
  for (const AverageStart& start : starts) out.push_back(find_attractor(system, start.p, start.state, options));
  return out;
}

}  // namespace graze
