// SPDX-License-Identifier: GPL-3.0-or-later
// Autonomous motions from return to return. The return map is compared with differences, exponents with multipliers, van der
// Pol's cycle with a separate Runge-Kutta method, and Roessler's attractor with published exponents.
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/basins/basins.hpp>
#include <graze/floquet/follow/sweep.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/floquet/orbit/stroboscopic_states.hpp>

#include "support/checks.hpp"
#include "support/sections.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

#include <array>
#include <numeric>

using namespace graze;
using namespace graze::support;

namespace {

/// Van der Pol's cycle by the classical Runge-Kutta method: its period, and the integral of the divergence over it.
struct Cycle {
  double period = 0.0, divergence = 0.0;
};

Cycle runge_kutta_cycle(double mu) {
  using State = std::array<double, 3>;  // x, v, integral of the divergence
  const auto rate = [mu](const State& s) {
    const double divergence = mu * (1.0 - s[0] * s[0]);
    return State{s[1], divergence * s[1] - s[0], divergence};
  };
  const auto along = [](const State& s, double h, const State& k) {
    return State{s[0] + h * k[0], s[1] + h * k[1], s[2] + h * k[2]};
  };
  const auto step = [&](const State& s, double h) {
    const State a = rate(s), b = rate(along(s, 0.5 * h, a)), c = rate(along(s, 0.5 * h, b)), d = rate(along(s, h, c));
    State out;
    for (std::size_t i = 0; i < 3; ++i) out[i] = s[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
    return out;
  };
  constexpr double h = 5e-4;
  State s{0.0, 2.0, 0.0};
  double t = 0.0, last_t = 0.0, last_divergence = 0.0;
  Cycle cycle;
  for (int turn = 0; turn < 40;) {
    const State next = step(s, h);
    if (s[0] < 0.0 && next[0] >= 0.0) {  // Newton's method for the length of the step to x = 0
      double part = h * -s[0] / (next[0] - s[0]);
      State at = step(s, part);
      for (int i = 0; i < 4; ++i) {
        part -= at[0] / at[1];
        at = step(s, part);
      }
      cycle = {t + part - last_t, at[2] - last_divergence};
      last_t = t + part;
      last_divergence = at[2];
      ++turn;
    }
    s = next;
    t += h;
  }
  return cycle;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// Sweep up and down of a system of two states at its default parameters, with short transients.
std::vector<SweepRow> up_and_down(const HybridSystem& system, SweepOptions options, int first_transient) {
  options.directions = {SweepDirection::up, SweepDirection::down};
  options.first_transient = first_transient;
  options.attractor.transient = 100;
  options.attractor.periods_on_orbit = 0;
  return sweep(system, default_parameters(system.parameters), vector({0.5, 0.0}), options);
}

}  // namespace

TEST_CASE("the derivative of the return map agrees with differences") {
  struct Case {
    HybridSystem system;
    Vector start;
  };
  for (const Case& one : {Case{van_der_pol(), vector({0.3, 0.7})}, Case{roessler(), vector({3.0, -1.0, 0.1})},
                          Case{van_der_pol_stop(), vector({0.1, 0.2})}}) {
    INFO(one.system.name);
    const Vector p = default_parameters(one.system.parameters);
    Propagator propagator(one.system, p);
    Transition period, moved;
    carry_period(propagator, one.start, {}, period);
    REQUIRE(period.termination == Termination::time);
    const Eigen::Index n = one.start.size();
    Vector f0(n), f1(n);
    propagator.field(period.mode0, 0.0, one.start, f0);
    propagator.field(period.mode1, 0.0, period.x1, f1);
    CHECK((period.Phi * f0 - f1).norm() < 1e-11 * f1.norm());
    CHECK((period_map(period) * f0).norm() < 1e-11 * f1.norm());
    CHECK(std::abs(period.log_det - period.liouville) < 1e-11);
    for (Eigen::Index k = 0; k < n; ++k) {
      constexpr double h = 1e-5;
      Vector ends[2];
      for (const int side : {0, 1}) {
        Vector x = one.start;
        x[k] += side == 0 ? h : -h;
        carry_period(propagator, x, {.sensitivity = Sensitivity::none}, moved);
        ends[side] = moved.x1;
      }
      CHECK(((ends[0] - ends[1]) / (2.0 * h) - period_map(period).col(k)).norm() < 1e-7);
    }
  }
}

TEST_CASE("a motion that starts on a return begins after it") {
  const HybridSystem system = van_der_pol();
  Propagator propagator(system, default_parameters(system.parameters));
  const std::vector<Vector> states = stroboscopic_states(propagator, vector({0.3, 0.7}), 30);
  REQUIRE(states.size() == 30);
  Transition transition;
  for (std::size_t k = 1; k < states.size(); ++k) {
    CHECK(std::abs(states[k][0]) < 1e-12);
    CHECK(states[k][1] > 0.0);
    carry_period(propagator, states[k], {.sensitivity = Sensitivity::none}, transition);
    CHECK(transition.duration > 6.0);
    CHECK(transition.event_sequence == std::vector<std::size_t>{1, 0});
  }
}

TEST_CASE("the exponents of van der Pol's cycle agree with a Runge-Kutta method") {
  for (const double mu : {0.3, 1.0, 3.0}) {
    INFO("mu = " << mu);
    const HybridSystem system = van_der_pol();
    const Vector p = parameters(system, {{"mu", mu}});
    const Cycle cycle = runge_kutta_cycle(mu);
    const double expected = cycle.divergence / cycle.period;
    const Attractor attractor = find_attractor(system, p, vector({0.1, 0.0}), {.transient = 100});
    REQUIRE(attractor.type == AttractorType::periodic);
    CHECK(attractor.period == 1);
    CHECK(attractor.duration == Approx(cycle.period).epsilon(1e-9));
    CHECK(std::abs(attractor.exponents[0]) < 1e-10);
    CHECK(attractor.exponents[1] == Approx(expected).epsilon(1e-8));
    const LyapunovSpectrum& mean = attractor.time_average;
    CHECK(mean.duration / static_cast<double>(mean.periods) == Approx(cycle.period).epsilon(1e-8));
    CHECK(mean.liouville_residual < 1e-10);
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}})
      CHECK(std::abs(mean.exponents[i] - attractor.exponents[i]) < 5.0 * mean.standard_errors[i] + 1e-12);
    CHECK(sum(mean.exponents) == Approx(expected).epsilon(1e-8));
  }
}

TEST_CASE("the exponents of a cycle with impacts agree with its multipliers") {
  const HybridSystem system = van_der_pol_stop();
  const Vector p = default_parameters(system.parameters);
  const Attractor attractor = find_attractor(system, p, vector({0.5, 0.0}), {.transient = 200});
  REQUIRE(attractor.type == AttractorType::periodic);
  CHECK(attractor.period == 1);
  CHECK(attractor.impacts == 1);
  const PeriodicOrbit orbit = shoot(system, p, std::vector<Vector>{vector({-1.5, 0.0})}, 1, {}, 5.0);
  REQUIRE(orbit.converged());
  CHECK(attractor.duration == Approx(orbit.duration).epsilon(1e-11));
  CHECK(attractor.exponents[1] == Approx(std::log(std::abs(orbit.multipliers.values.front())) / orbit.duration).epsilon(1e-9));
  CHECK(std::abs(attractor.state[0] - p[1]) < 1e-12);  // the section is the stop
  const LyapunovSpectrum& mean = attractor.time_average;
  CHECK(mean.liouville_residual < 1e-10);
  CHECK(std::abs(mean.exponents[1] - attractor.exponents[1]) < 5.0 * mean.standard_errors[1] + 1e-12);
}

TEST_CASE("Roessler's attractor has its published exponents and one of them is zero") {
  const HybridSystem system = roessler();
  const Vector p = default_parameters(system.parameters);
  AttractorOptions options;
  options.lyapunov.standard_error = 1e-3;
  const Attractor attractor = find_attractor(system, p, vector({1.0, 1.0, 0.0}), options);
  REQUIRE(attractor.type == AttractorType::chaotic);
  REQUIRE(attractor.exponents.size() == 3);
  // Sprott, Chaos and Time-Series Analysis (2003), table A.5: 0.0714, 0, -5.3943.
  const std::array published = {0.0714, 0.0, -5.3943};
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
    CHECK(attractor.standard_errors[i] < 1e-3);
    CHECK(std::abs(attractor.exponents[i] - published[i]) < 5.0 * attractor.standard_errors[i] + 1e-4);
  }
  CHECK(std::abs(attractor.exponents[1]) < 5.0 * attractor.standard_errors[1]);
  CHECK(attractor.time_average.liouville_residual < 1e-9);

  // Over four motions: the returns of each have times of their own.
  LyapunovOptions averaging;
  averaging.motions = 4;
  averaging.standard_error = 0.0;
  averaging.max_periods = 8000;
  const LyapunovSpectrum four = lyapunov_spectrum(system, p, attractor.state, averaging);
  CHECK(four.others.size() == 3);
  CHECK(four.duration / static_cast<double>(four.periods) ==
        Approx(attractor.time_average.duration / static_cast<double>(attractor.time_average.periods)).epsilon(0.01));
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
    CHECK(four.standard_errors[i] > 0.0);
    CHECK(four.standard_errors[i] < 2e-3);
    CHECK(std::abs(four.exponents[i] - published[i]) < 5.0 * four.standard_errors[i] + 1e-4);
  }
}

TEST_CASE("standard errors over returns of different length agree with the scatter of independent runs") {
  const HybridSystem system = roessler();
  const Vector p = default_parameters(system.parameters);
  LyapunovOptions options;
  options.standard_error = 0.0;
  options.max_periods = 800;
  std::vector<double> values;
  double errors = 0.0;
  Vector state = vector({1.0, 1.0, 0.0});
  constexpr int runs = 12;
  for (int run = 0; run <= runs; ++run) {
    const LyapunovSpectrum mean = lyapunov_spectrum(system, p, state, options);
    state = mean.state;
    if (run == 0) continue;  // the transient
    values.push_back(mean.exponents[0]);
    errors += mean.standard_errors[0] / runs;
  }
  const double mean = sum(values) / runs;
  double spread = 0.0;
  for (const double value : values) spread += (value - mean) * (value - mean) / (runs - 1);
  // The spread of twelve runs has a relative error of a fifth; the test allows three times that.
  CHECK(std::sqrt(spread) == Approx(errors).epsilon(0.65));
}

TEST_CASE("a sweep of an autonomous system counts returns on one thread or two") {
  // Period doublings of Roessler's cycle at a = b = 0.1: period 1 at c = 4, period 2 at 6, period 4 at 8.5; chaos at 9.
  const HybridSystem system = roessler();
  const Vector p = parameters(system, {{"a", 0.1}, {"b", 0.1}});
  SweepOptions options;
  options.parameter = "c";
  options.from = 4.0;
  options.to = 9.0;
  options.step = 0.5;
  options.first_transient = 300;
  options.samples = 20;
  options.attractor.transient = 300;
  options.attractor.periods_on_orbit = 0;
  options.attractor.lyapunov.standard_error = 5e-3;
  const std::vector<SweepRow> rows = sweep(system, p, vector({1.0, 1.0, 0.0}), options);
  REQUIRE(rows.size() == 11);
  for (const auto& [row, period] : {std::pair{0, 1}, {4, 2}, {9, 4}}) {
    const Attractor& attractor = rows[static_cast<std::size_t>(row)].attractor;
    REQUIRE(attractor.type == AttractorType::periodic);
    CHECK(attractor.period == period);
    CHECK(rows[static_cast<std::size_t>(row)].states.size() == static_cast<std::size_t>(period));
    for (const Vector& state : rows[static_cast<std::size_t>(row)].states) CHECK(std::abs(state[1]) < 1e-11);
  }
  CHECK(rows.back().attractor.type == AttractorType::chaotic);
  CHECK(rows.back().states.size() == 20);
  options.threads = 2;
  const std::vector<SweepRow> again = sweep(system, p, vector({1.0, 1.0, 0.0}), options);
  REQUIRE(again.size() == rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    CHECK(again[k].states == rows[k].states);
    CHECK(again[k].attractor.exponents == rows[k].attractor.exponents);
  }
}

TEST_CASE("where a cycle no longer meets its event a sweep says so, value by value, and goes on (fixed)") {
  // The amplitude of the cycle for mu = 1/2 is 2.0 to two digits: no stop is met beyond. A flight without return used up its
  // steps and counted as a failure.
  const HybridSystem system = van_der_pol_stop();
  const std::vector<SweepRow> rows = up_and_down(system, {.parameter = "r", .from = 1.8, .to = 2.3, .step = 0.1}, 200);
  REQUIRE(rows.size() == 12);
  for (const SweepRow& row : rows) {
    INFO(row.value);
    const bool meets = row.value < 1.95;
    if (meets) CHECK(row.attractor.type == AttractorType::periodic);
    if (row.value > 2.05) CHECK(row.attractor.termination == Termination::no_return);
  }
}

TEST_CASE("the stop of an autonomous system may move from value to value") {
  const HybridSystem system = van_der_pol_stop();
  const std::vector<SweepRow> rows = up_and_down(system, {.parameter = "r", .from = 0.8, .to = 1.2, .step = 0.1}, 200);
  REQUIRE(rows.size() == 10);
  for (const SweepRow& row : rows) {
    CHECK(row.attractor.type == AttractorType::periodic);
    CHECK(row.attractor.period == 1);
    CHECK(row.states.front()[0] == Approx(row.value).epsilon(1e-12));
    CHECK(row.impact_speeds.size() == 1);
  }
  for (std::size_t k = 0; k < 5; ++k) CHECK(rows[k].attractor.duration == Approx(rows[9 - k].attractor.duration).epsilon(1e-10));
}

TEST_CASE("starts of an autonomous system are distinguished by their returns") {
  const HybridSystem system = van_der_pol();
  Matrix starts(2, 9);
  for (int i = 0; i < 9; ++i) starts.col(i) = vector({-2.0 + 0.5 * i, 0.25});
  BasinOptions options;
  options.transient = 100;
  const Basins basins = find_attractors(system, default_parameters(system.parameters), starts, options);
  REQUIRE(basins.attractors.size() == 1);
  CHECK(basins.attractors.front().count == 9);
  CHECK(basins.attractors.front().attractor.period == 1);
}

TEST_CASE("a motion that does not return is reported") {
  const HybridSystem system = van_der_pol();
  const Vector p = parameters(system, {{"mu", -3.0}});  // the origin is a stable node
  const Attractor attractor = find_attractor(system, p, vector({0.1, 0.0}), {.transient = 100});
  CHECK(attractor.termination == Termination::no_return);
  CHECK(attractor.state.norm() < 1e-6);
}

TEST_CASE("a sweep continues after values at which the motion comes to rest") {
  const HybridSystem system = van_der_pol();
  const std::vector<SweepRow> rows = up_and_down(system, {.parameter = "mu", .from = -3.0, .to = 3.0, .step = 2.0}, 100);
  REQUIRE(rows.size() == 8);
  for (const SweepRow& row : rows) {
    INFO("mu = " << row.value);
    CHECK((row.attractor.type == AttractorType::periodic) == (row.value > 0.0));
    CHECK((row.attractor.termination == Termination::no_return) == (row.value < 0.0));
    if (row.value < 0.0) CHECK(row.attractor.state.norm() < 1e-6);
  }
}

TEST_CASE("a motion that spirals into an equilibrium rests there and is no cycle (fixed)") {
  // The origin is a focus, stable for mu < 0: returns decrease to rounding.
  const HybridSystem system = van_der_pol();
  const std::vector<SweepRow> rows = up_and_down(system, {.parameter = "mu", .from = -0.5, .to = 0.5, .step = 0.2}, 300);
  REQUIRE(rows.size() == 12);
  for (const SweepRow& row : rows) {
    INFO("mu = " << row.value);
    CHECK((row.attractor.type == AttractorType::periodic) == (row.value > 0.0));
    CHECK((row.attractor.termination == Termination::no_return) == (row.value < 0.0));
    if (row.value < 0.0) CHECK(row.attractor.state.norm() < 1e-7);
  }
}
