// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeps: rows against separately computed orbits and motions, continuation from any row, and any number of threads. Also
// tested: predicted orbits, and laminar phases.
#include <graze/floquet/follow/predicted_orbits.hpp>
#include <graze/floquet/follow/sweep.hpp>
#include <graze/floquet/follow/sweep_chain.hpp>
#include <graze/floquet/orbit/shooting.hpp>

#include "support/damped_hertz.hpp"
#include "support/newton_oscillator.hpp"
#include "support/system_texts.hpp"
#include "support/two_sided_oscillator.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>
#include <oneapi/tbb/global_control.h>

#include <atomic>
#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

/// Steps of 1e-4, with the exponents of orbits from their multipliers alone.
SweepOptions fine_sweep(double from, double to, SweepDirection direction) {
  SweepOptions options;
  options.from = from;
  options.to = to;
  options.step = 0.0001;
  options.directions = {direction};
  options.attractor.periods_on_orbit = 0;
  return options;
}

/// With short averages.
SweepOptions coarse_averages(SweepOptions options) {
  options.attractor.transient = 100;
  options.attractor.lyapunov.standard_error = 5e-3;
  options.attractor.lyapunov.min_periods = 200;
  options.attractor.lyapunov.max_periods = 4000;
  options.samples = 20;
  return options;
}

bool same(const SweepRow& a, const SweepRow& b) {
  return a.value == b.value && a.direction == b.direction && a.attractor.type == b.attractor.type &&
         a.attractor.period == b.attractor.period && a.attractor.impacts == b.attractor.impacts &&
         a.attractor.state == b.attractor.state && a.attractor.exponents == b.attractor.exponents &&
         a.attractor.standard_errors == b.attractor.standard_errors && a.states == b.states && a.end == b.end &&
         a.impact_speeds == b.impact_speeds;
}

bool same(const std::vector<SweepRow>& a, const std::vector<SweepRow>& b) {
  return a.size() == b.size() &&
         std::equal(a.begin(), a.end(), b.begin(), [](const SweepRow& one, const SweepRow& other) { return same(one, other); });
}

/// Orbits, chaos, and rows that look chaotic until their averages end on orbits.
std::vector<SweepRow> varied(const SweepOptions& options, const std::vector<SweepRow>& so_far = {}) {
  return sweep(damped_hertz(), hertz_parameters(), Vector{{0.0, 0.0}}, options, so_far);
}
SweepOptions varied_options() {
  SweepOptions options = coarse_averages(fine_sweep(0.7300, 0.7410, SweepDirection::up));
  options.step = 0.0002;
  return options;
}

}  // namespace

TEST_CASE("sweep: past a period doubling it continues with the doubled orbit") {
  // The PD is at eta = 0.919542643. The end of a row is an orbit to rounding, and the unstable orbit of the next value is
  // near.
  const std::vector<SweepRow> rows =
      sweep(damped_hertz(), hertz_parameters(), Vector{{0.0, 0.0}}, fine_sweep(0.9190, 0.9198, SweepDirection::down));
  REQUIRE(rows.size() == 9);
  for (const SweepRow& row : rows) {
    INFO(row.value);
    CHECK(row.attractor.type == AttractorType::periodic);
    CHECK(row.attractor.period == (row.value > 0.919542643 ? 1 : 2));
  }
}

TEST_CASE("sweep: a row has the states, impacts and properties of its orbit") {
  const std::vector<SweepRow> rows =
      sweep(damped_hertz(), hertz_parameters(), Vector{{0.0, 0.0}}, fine_sweep(0.9190, 0.9194, SweepDirection::down));
  for (const SweepRow& row : rows) {
    INFO(row.value);
    CHECK(row.attractor.period == 2);
    REQUIRE(row.attractor.multipliers.size() == 2);
    CHECK(std::abs(row.attractor.multipliers[0]) < 1.0);
    const PeriodicOrbit orbit = shoot(damped_hertz(), hertz_parameters(row.value), row.states, 2);
    REQUIRE(orbit.converged());
    for (std::size_t k = 0; k < 2; ++k) CHECK(std::abs(row.attractor.multipliers[k] - orbit.multipliers.values[k]) < 1e-7);
    CHECK(row.attractor.isolated_impacts == row.attractor.impacts);
    CHECK(!row.attractor.orbit);  // there may be a million rows
    REQUIRE(row.states.size() == 2);
    // The impacts of a free run that starts at the first state and returns to it.
    Propagator propagator(damped_hertz(), hertz_parameters(row.value));
    const double T = forcing_period(damped_hertz(), hertz_parameters(row.value));
    Transition run;
    carry(propagator, 0.0, 2.0 * T, row.states[0], {.sensitivity = Sensitivity::none, .keep_events = true}, run);
    CHECK((run.x1 - row.states[0]).norm() < 1e-11);
    CHECK((row.end - row.states[0]).norm() < 1e-11);
    std::vector<double> speeds;
    for (const EventRecord& event : run.events)
      if (begins_contact(event.kind)) speeds.push_back(event.normal_speed);
    REQUIRE(row.impact_speeds.size() == speeds.size());
    for (std::size_t k = 0; k < speeds.size(); ++k) CHECK(row.impact_speeds[k] == Approx(speeds[k]).epsilon(1e-11));
  }
}

TEST_CASE("sweep: a slow departure from an unstable orbit is not taken for chaos") {
  // Past the doubling of a 1/1 orbit. After the requested transients the motion is still near it; after some thousand periods
  // it is on 2/1.
  const Vector p = parameters(newton_oscillator(), {{"b", 0.02}, {"r", 1.0748}, {"k_r", 1.0}, {"xi", 0.5}, {"eta", 0.94318}});
  for (const int transient : {10, 30, 100}) {
    SweepOptions options = fine_sweep(0.528355, 0.588355, SweepDirection::up);
    options.parameter = "k_r";
    options.step = 0.02;
    options.attractor.transient = transient;
    options.attractor.lyapunov.max_periods = 20000;
    options.attractor.lyapunov.standard_error = 1e-3;
    const std::vector<SweepRow> rows = sweep(newton_oscillator(), p, Vector{{0.0, 0.0}}, options);
    REQUIRE(rows.size() == 4);
    INFO("transient " << transient);
    CHECK(rows[1].attractor.type == AttractorType::periodic);
    CHECK(rows[1].attractor.period == 2);
    CHECK(rows[1].attractor.impacts == 1);
  }
}

TEST_CASE("sweep: for an orbit and its double traversal the single one is found") {
  // After 24 periods the motion is closer than after 12: its multiplier is -0.98.
  const Vector p = parameters(newton_oscillator(), {{"b", 0.005}, {"r", 0.0}, {"k_r", 0.7}, {"xi", 1.0}});
  SweepOptions options = fine_sweep(1.0206608428392157, 1.0236608428392158, SweepDirection::up);
  options.step = 0.0003;
  const std::vector<SweepRow> rows = sweep(newton_oscillator(), p, Vector{{0.0, 0.0}}, options);
  REQUIRE(rows.size() >= 10);
  CHECK(rows[9].attractor.period == 12);
  CHECK(rows[9].attractor.impacts == 17);
}

TEST_CASE("sweep: chaos in narrow bands is not taken for a laminar phase") {
  // The cascade of the cantilever's 4/2 orbit ends in such narrow bands that the motion always repeats itself to 2e-3.
  const HybridSystem system = make_oscillator("cantilever", "linear");
  const Vector p = parameters(system, {{"b", 0.026}, {"xi", 0.08}, {"r", 0.079}, {"beta", 36.0 / 35.0}, {"k_S", 25.0}});
  const std::vector<SweepRow> rows = sweep(system, p, Vector{{0.0, 0.0}}, fine_sweep(0.5904, 0.5905, SweepDirection::up));
  REQUIRE(rows.size() == 2);
  for (const SweepRow& row : rows) CHECK(row.attractor.type == AttractorType::chaotic);
  CHECK(rows[1].attractor.exponents[0] < 0.008);
}

TEST_CASE("sweep: orbits of many periods are recognised by the returns of their motions") {
  // Windows of 96 and of 128 periods in the chaos of the damped Hertz oscillator.
  SweepOptions options = fine_sweep(0.7332, 0.7348, SweepDirection::up);
  options.step = 0.0016;
  options.attractor.max_period = 256;
  options.attractor.transient = 300;
  options.attractor.lyapunov.max_periods = 20000;
  options.attractor.lyapunov.min_periods = 500;
  const std::vector<SweepRow> rows = varied(options);
  REQUIRE(rows.size() == 2);
  const int n[] = {96, 128};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const SweepRow& row = rows[k];
    INFO(row.value);
    CHECK(row.attractor.type == AttractorType::periodic);
    CHECK(row.attractor.period == n[k]);
    REQUIRE(row.states.size() == static_cast<std::size_t>(n[k]));
    // A free run returns after that number of periods, and not before.
    Propagator propagator(damped_hertz(), hertz_parameters(row.value));
    const double T = forcing_period(damped_hertz(), hertz_parameters(row.value));
    Transition run;
    Vector x = row.states[0];
    double nearest = 1.0;
    for (int period = 1; period <= n[k]; ++period) {
      if (period > 1) nearest = std::min(nearest, (x - row.states[0]).norm());
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none}, run);
      x = run.x1;
    }
    CHECK(nearest > 1e-4);
    CHECK((x - row.states[0]).norm() < 1e-9);
  }
  options.attractor.max_period = 95;
  for (const SweepRow& row : varied(options)) CHECK(row.attractor.type == AttractorType::undecided);
}

TEST_CASE("sweep: it ends where the final state of one value lies inside the barrier of the next") {
  // Chaos, abandoned early, and a hard stop that moves towards it.
  const Vector p = parameters(newton_oscillator(), {{"eta", 0.7114}, {"r", 2.0}});
  SweepOptions options = coarse_averages(fine_sweep(1.5, 2.0, SweepDirection::down));
  options.parameter = "r";
  options.step = 0.1;
  options.threads = GENERATE(1, 2);
  const std::vector<SweepRow> rows = sweep(newton_oscillator(), p, Vector{{0.0, 0.0}}, options);
  REQUIRE(!rows.empty());
  REQUIRE(rows.size() < 6);
  CHECK(rows.back().end[0] > rows.back().value - 0.1);
  for (std::size_t k = 1; k < rows.size(); ++k) CHECK(rows[k - 1].end[0] <= rows[k].value);
}

TEST_CASE("sweep: it continues from any of its rows with identical bits") {
  const std::vector<SweepRow> whole = varied(varied_options());
  REQUIRE(whole.size() == 56);
  const auto chaotic = [](const SweepRow& row) { return row.attractor.type == AttractorType::chaotic; };
  CHECK(std::count_if(whole.begin(), whole.end(), chaotic) > 10);
  CHECK(std::count_if(whole.begin(), whole.end(), chaotic) < 50);
  for (std::size_t kept = 1; kept < whole.size(); kept += 6) {  // before, at and after the starts of blocks
    INFO(kept);
    CHECK(same(varied(varied_options(), {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(kept)}), whole));
  }
}

TEST_CASE("sweep: it stays on its attractor even if the first start leads to another one") {
  // The impactless orbit, up to its grazing. From rest there is chaos beside it, on which the speculative stretches begin.
  SweepOptions options = coarse_averages(fine_sweep(0.6950, 0.7044, SweepDirection::up));
  options.step = 0.0002;
  options.threads = GENERATE(1, 2);
  const Vector rest{{0.0, 0.0}};
  const std::vector<SweepRow> rows = sweep(damped_hertz(), hertz_parameters(), rest, options);
  REQUIRE(rows.size() == 48);
  for (const SweepRow& row : rows) {  // x(0) of the harmonic motion
    const double d = 1.0 - row.value * row.value, f = 2.0 * 0.05 * row.value;
    INFO(row.value);
    CHECK(row.attractor.impacts == 0);
    CHECK(row.attractor.state[0] == Approx(d / (d * d + f * f)).epsilon(1e-9));
  }
  AttractorOptions alone;
  alone.periods_on_orbit = 0;
  for (const std::size_t k : {31U, 47U})
    CHECK(find_attractor(damped_hertz(), hertz_parameters(rows[k].value), rest, alone).type == AttractorType::chaotic);
}

TEST_CASE("sweep: an intermediate result is the beginning of the whole and does not interrupt the sweep") {
  const std::vector<SweepRow> whole = varied(varied_options());
  SweepOptions options = varied_options();
  options.threads = GENERATE(1, 3);
  std::size_t reported = 0, longest = 0;
  options.keep = [&](const std::function<std::vector<SweepRow>()>& so_far) {
    if (++reported % 5 != 0) return;
    const std::vector<SweepRow> part = so_far();
    CHECK(part.size() >= longest);
    longest = part.size();
    CHECK(same(part, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(part.size())}));
  };
  CHECK(same(varied(options), whole));
  CHECK(reported >= whole.size());
  CHECK(longest > 0);
}

TEST_CASE("sweep: any number of threads gives identical bits") {
  SweepOptions options = varied_options();
  options.directions = {SweepDirection::up, SweepDirection::down};
  const std::vector<SweepRow> one = varied(options);
  const oneapi::tbb::global_control more_than_processors(oneapi::tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {2, 3, 5}) {
    options.threads = threads;
    CHECK(same(varied(options), one));
  }
}

TEST_CASE("sweep: if it is cancelled its completed rows are kept and agree with the whole") {
  const std::vector<SweepRow> whole = varied(varied_options());
  for (const int most : {1, 20, 300, 3000}) {
    std::atomic<int> cancel_checks = 0;
    SweepOptions options = varied_options();
    options.threads = 2;
    options.cancelled = [&] { return ++cancel_checks > most; };
    const std::vector<SweepRow> part = varied(options);
    INFO(most << ": " << part.size());
    REQUIRE(part.size() < whole.size());
    CHECK(same(part, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(part.size())}));
    options.cancelled = {};
    CHECK(same(varied(options, part), whole));
  }
}

TEST_CASE("sweep: on a smooth branch each row is the settled motion from the one before") {
  const auto [from, to, direction] = GENERATE(table<double, double, SweepDirection>(
      {{0.930, 0.936, SweepDirection::up}, {0.915, 0.921, SweepDirection::down}, {0.760, 0.766, SweepDirection::up}}));
  const std::vector<SweepRow> rows =
      sweep(damped_hertz(), hertz_parameters(), Vector{{0.0, 0.0}}, fine_sweep(from, to, direction));
  REQUIRE(rows.size() == 61);
  AttractorOptions alone;
  alone.periods_on_orbit = 0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    const Attractor reached = find_attractor(damped_hertz(), hertz_parameters(rows[k].value), rows[k - 1].end, alone);
    const Attractor& attractor = rows[k].attractor;
    INFO(rows[k].value);
    REQUIRE(reached.type == AttractorType::periodic);
    CHECK(attractor.period == reached.period);
    CHECK(attractor.impacts == reached.impacts);
    for (std::size_t i = 0; i < 2; ++i) CHECK(attractor.exponents[i] == Approx(reached.exponents[i]).margin(1e-9));
    double apart = 1.0;
    for (const Vector& state : reached.orbit->states) apart = std::min(apart, (state - attractor.state).norm());
    CHECK(apart < 1e-9);
  }
}

TEST_CASE("sweep: oscillators that the lanes do not support are followed alone") {
  const HybridSystem system = two_sided_oscillator(true);
  const Vector p = default_parameters(system.parameters);
  SweepOptions options = coarse_averages(fine_sweep(1.0, 1.01, SweepDirection::up));
  options.parameter = system.parameters[*system.forcing_frequency].name;
  options.step = 0.002;
  const std::vector<SweepRow> one = sweep(system, p, Vector::Zero(static_cast<Eigen::Index>(system.states)), options);
  options.threads = 2;
  CHECK(one.size() == 6);
  CHECK(same(sweep(system, p, Vector::Zero(static_cast<Eigen::Index>(system.states)), options), one));
}

TEST_CASE("predicted orbits agree with Newton's method up to the loss of stability") {
  // The PD is at eta = 0.919542643.
  constexpr double begin = 0.9230, step = -0.0002;
  const auto orbit_at = [](double eta) { return shoot(damped_hertz(), hertz_parameters(eta), Vector{{2.05, 1.4}}, 1); };
  std::vector<std::vector<Vector>> before;
  for (int k = 0; k < 5; ++k) before.push_back(orbit_at(begin + k * step).states);
  std::vector<Vector> next;
  for (int k = 5; k < 25; ++k) next.push_back(hertz_parameters(begin + k * step));
  const std::vector<PredictedOrbit> ahead = predicted_orbits(damped_hertz(), before, next);
  REQUIRE(ahead.size() == 13);  // to 0.9196
  for (std::size_t k = 0; k < ahead.size(); ++k) {
    const PeriodicOrbit orbit = orbit_at(begin + (5 + static_cast<double>(k)) * step);
    const StableOrbit& found = ahead[k].orbit;
    CHECK((found.states.front() - orbit.state).norm() < 1e-11);
    CHECK(found.impacts == 1);
    CHECK(found.isolated_impacts == 1);
    for (std::size_t i = 0; i < 2; ++i) CHECK(std::abs(found.multipliers.values[i] - orbit.multipliers.values[i]) < 1e-10);
    REQUIRE(ahead[k].impact_speeds.size() == 1);
    CHECK(ahead[k].impact_speeds[0] == Approx(orbit.events[1].normal_speed).epsilon(1e-11));  // event 0 leaves the contact
  }
  CHECK(predicted_orbits(damped_hertz(), {before.back()}, next).empty());
  // By Propagators the same, and whole.
  const std::vector<PredictedOrbit> one_by_one = predicted_orbits(damped_hertz(), before, next, {.kind = FlowKind::alone});
  REQUIRE(one_by_one.size() == ahead.size());
  for (std::size_t k = 0; k < ahead.size(); ++k) {
    const StableOrbit& found = one_by_one[k].orbit;
    CHECK((found.states.front() - ahead[k].orbit.states.front()).norm() < 1e-11);
    CHECK(found.whole);
    CHECK_FALSE(ahead[k].orbit.whole);
    REQUIRE(one_by_one[k].impact_speeds.size() == 1);
    CHECK(one_by_one[k].impact_speeds[0] == Approx(ahead[k].impact_speeds[0]).epsilon(1e-11));
  }
}

TEST_CASE("predicted orbits begin at the same state as those before them") {
  // An orbit of period 2, given alternately from its first and from its second state.
  constexpr double begin = 0.915, step = 0.0001;
  std::vector<std::vector<Vector>> before;
  std::vector<Vector> next;
  for (int k = 0; k < 4; ++k) {
    const Attractor attractor = find_attractor(damped_hertz(), hertz_parameters(begin + k * step), Vector{{0.0, 0.0}});
    REQUIRE(attractor.period == 2);
    before.push_back(attractor.orbit->states);
    // Every other time it starts at the upper one.
    if ((before.back()[0][0] < before.back()[1][0]) == (k % 2 == 0)) std::swap(before.back()[0], before.back()[1]);
    next.push_back(hertz_parameters(begin + (k + 4) * step));
  }
  const std::vector<PredictedOrbit> ahead = predicted_orbits(damped_hertz(), before, next);
  REQUIRE(ahead.size() == 4);
  for (const auto& [orbit, speeds] : ahead) {
    CHECK((orbit.states[0] - before.back()[0]).norm() < 0.3 * (orbit.states[0] - orbit.states[1]).norm());
    CHECK((orbit.states[1] - before.back()[1]).norm() < 0.3 * (orbit.states[0] - orbit.states[1]).norm());
  }
}

TEST_CASE("sweep: a guess of a doubled orbit inside the barrier is rejected") {
  // The 2/1 orbit has just doubled, and the motion is far from it.
  const HybridSystem system = make_oscillator("cantilever", "newton");
  const Vector p = parameters(system, {{"b", 0.026}, {"beta", 1.0285714}, {"xi", 0.08}, {"r", 0.079}, {"k_r", 1.0}});
  SweepOptions options = coarse_averages(fine_sweep(0.498, 0.4985, SweepDirection::up));
  options.step = 0.0005;
  options.attractor.lyapunov.flow.kind = FlowKind::general;
  options.attractor.lyapunov.flow.tolerance = 1e-10;
  CHECK(sweep(system, p, Vector{{0.0, 0.0}}, options).size() == 2);
}

TEST_CASE("a sweep of a belt's speed follows the stick-slip cycle up to its end") {
  SystemWriter writer;
  writer.system.name = "belt";
  writer.parameter("V", "0.3");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.05"}}, {{"1"}}}).friction("belt", "v - V", "1", "0.5", "0.8");
  const HybridSystem system = equations::make_system(writer.system).system;
  SweepOptions options;
  options.parameter = "V";
  options.from = 0.1;
  options.to = 0.58;
  options.step = 0.04;
  options.directions = {SweepDirection::up};
  options.first_transient = 100;
  options.attractor.transient = 100;
  const std::vector<SweepRow> rows = sweep(system, default_parameters(system.parameters), Vector{{0.0, 0.0}}, options);
  REQUIRE(rows.size() == 13);
  // The slip that begins at x = 0.8 - 0.05 V, v = V is a damped oscillation about x = 0.5 and reaches v = V again up to this V.
  constexpr double last = 0.4984163;
  for (const SweepRow& row : rows) {
    INFO("V " << row.value);
    if (row.value < last) {
      CHECK(row.attractor.type == AttractorType::periodic);
    } else {
      CHECK(row.attractor.termination == Termination::no_return);
    }
  }
}

TEST_CASE("a sweep passes the value at which friction just holds a mass (fixed)") {
  // The force 0.8 cos(w t) is as large as the friction at mu = 0.8: whether it slips there, rounding decides.
  SystemWriter writer;
  writer.system.name = "edge";
  writer.forcing("w").parameter("w", "0.7").parameter("mu", "0.1");
  writer.mechanics({"q"}, {"p"}, {{{"1"}}, {{"0.05"}}, {{"0"}}, {"-sin(q) + 0.8*cos(w*t)"}});
  writer.friction("pivot", "p", "1", "mu");
  const HybridSystem system = equations::make_system(writer.system).system;
  for (const auto& [from, step] : {std::pair(0.7, 0.05), std::pair(0.6, 0.1)}) {
    SweepOptions options;
    options.parameter = "mu";
    options.from = from;
    options.to = 0.9;
    options.step = step;
    options.directions = {SweepDirection::down};
    options.first_transient = 100;
    options.attractor.transient = 100;
    options.attractor.periods_on_orbit = 0;
    options.attractor.lyapunov.max_periods = 2000;
    const std::vector<SweepRow> rows = sweep(system, default_parameters(system.parameters), vector({0.0, 0.0}), options);
    CHECK(rows.size() == static_cast<std::size_t>(std::lround((0.9 - from) / step)) + 1);
  }
}

TEST_CASE("a sweep without forcing goes on where the stop turns back") {
  // The stop moves outward up to a = 1/2 and inward again; the states of the orbits lie on it, and are no guesses beyond.
  SystemWriter writer;
  writer.system.name = "turning stop";
  writer.states({"x", "v"}).parameter("mu", "0.3").parameter("a", "0").parameter("e", "0.7");
  writer.mode("flight", "x' = v\nv' = mu*(1 - x^2)*v - x");
  writer.event({"stop", "impact", "x - 1 + 0.1*(a - 0.5)^2", "v = -e*v", "", ""});
  writer.system.events.back().count = 1;
  const HybridSystem system = equations::make_system(writer.system).system;
  SweepOptions options;
  options.parameter = "a";
  options.from = 0.35;
  options.to = 0.65;
  options.step = 0.001;  // 301 values; the orbits of forced systems would be predicted in such a sweep
  options.directions = {SweepDirection::up};
  options.first_transient = options.attractor.transient = 100;
  options.attractor.periods_on_orbit = 0;
  const std::vector<SweepRow> rows = sweep(system, default_parameters(system.parameters), Vector{{0.1, 0.1}}, options);
  REQUIRE(rows.size() == 301);
  for (const SweepRow& row : rows) {
    INFO("a " << row.value);
    CHECK(row.attractor.type == AttractorType::periodic);
    CHECK(row.attractor.impacts == 1);
  }
}

TEST_CASE("orbits are predicted with forcing only") {
  // Without it their states lie on a guard, which moves with the parameter.
  const auto predicts = [](const HybridSystem& system, const std::string& parameter) {
    SweepOptions options;
    options.parameter = parameter;
    options.from = 1.0;
    options.to = 1.1;
    options.step = 0.01;
    options.attractor.periods_on_orbit = 0;
    const Vector rest = Vector::Zero(static_cast<Eigen::Index>(system.states));
    return SweepChain(system, default_parameters(system.parameters), rest, options, SweepDirection::up).predicts();
  };
  CHECK(predicts(damped_hertz(), "eta"));
  CHECK(predicts(two_sided_oscillator(true), "eta"));
  CHECK_FALSE(predicts(van_der_pol_stop(), "r"));
}
