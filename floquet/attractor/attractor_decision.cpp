// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/attractor_decision.hpp>
#include <graze/floquet/attractor/transient.hpp>
#include <graze/floquet/exponents/exponents.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace graze {

namespace {

constexpr int most_rounds = 3;

/// A conservative motion is ordered if its tangent has not grown beyond shear after this many periods: chaos with an exponent
/// above ln(1e7) / 1000 = 0.016 a period would have shown.
constexpr std::int64_t periods_on_island = 1000;

/// Exponent of e^40: growth that takes a rounding error to order one.
constexpr double e_folds_of_rounding = 40.0;

/// Exponent per forcing period: a distance grows by its exponential.
double growth(const Attractor& attractor, double T) {
  return attractor.type == AttractorType::chaotic ? attractor.exponents[0] * T : 0.0;
}

}  // namespace

void push_off(const HybridSystem& system, const Vector& p, int round, Vector& state) {
  const double far = 1e-4 * std::pow(10.0, round) * (1.0 + state.lpNorm<Eigen::Infinity>());
  for (const double way : {-far, far}) {
    Vector pushed = state;
    for (Eigen::Index i = 0; 2 * i < state.size(); ++i) pushed[i] += way / static_cast<double>(1 + i);
    if (!mode_at(system, 0.0, pushed, p)) continue;
    state = pushed;
    return;
  }
}

int longer_transient(int transient) {
  constexpr int shortest = 300;
  return 3 * std::max(transient, shortest);
}

bool may_be_laminar(const Attractor& attractor, int round, double T) {
  if (attractor.time_average.conservative()) return false;  // it approaches nothing else
  return round == 0 || growth(attractor, T) * static_cast<double>(attractor.time_average.periods_each()) <= e_folds_of_rounding;
}

LaminarPhase laminar_watch(const Attractor& attractor, int period, double T, const AttractorOptions& options) {
  constexpr double most = 20000.0;
  const double each = growth(attractor, T);
  const bool can_tell = each * most > e_folds_of_rounding;
  return {attractor.state, period, return_tolerance(options),
          can_tell ? static_cast<std::int64_t>(e_folds_of_rounding / each) : 0};
}

bool goes_on(const LaminarPhase& watch, const HybridSystem& system, const Vector& p, int round, Attractor& attractor) {
  if (!watch.goes_on()) return false;
  if (round == most_rounds) {
    if (watch.always()) attractor.type = AttractorType::undecided;
    return false;
  }
  if (watch.on_an_orbit()) push_off(system, p, round, attractor.state);
  return true;
}

void evaluate_average(LyapunovSpectrum average, const AttractorOptions& options, Attractor& attractor) {
  attractor.time_average = std::move(average);
  attractor.state = attractor.time_average.state;
  attractor.exponents = attractor.time_average.exponents;
  attractor.standard_errors = attractor.time_average.standard_errors;
  const LyapunovSpectrum& mean = attractor.time_average;
  const bool is_chaos = grows_beyond_shear(mean.log_growth, mean.log_volume, mean.periods_each());
  const bool positive =
      !attractor.exponents.empty() && attractor.exponents[0] > options.significance * attractor.standard_errors[0];
  attractor.type = positive && is_chaos ? AttractorType::chaotic : AttractorType::undecided;
  attractor.conservative = mean.conservative();
  attractor.motion = ConservativeMotion::unknown;
  if (attractor.conservative && is_chaos) attractor.motion = ConservativeMotion::chaotic_sea;
  if (attractor.conservative && !is_chaos && mean.periods_each() >= periods_on_island)
    attractor.motion = ConservativeMotion::island;
}

bool needs_confirmation(const AttractorOptions& options, const Attractor& attractor) {
  return options.recurrence > 0.0 && attractor.type == AttractorType::chaotic &&
         attractor.time_average.stop == LyapunovStop::standard_error && attractor.time_average.periods < options.confirmed_below;
}

}  // namespace graze
