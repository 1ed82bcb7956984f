// SPDX-License-Identifier: GPL-3.0-or-later
// Settled transients: their attractors and their terminations.
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"
#include "support/damped_hertz.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

const Vector rest = Vector::Zero(2);

}  // namespace

TEST_CASE("a settled run finds the period of the attractor and shooting confirms it") {
  struct Case {
    double eta, b_H;
    int period;
  };
  for (const Case& c : {Case{0.925, 0.1, 1}, {0.91, 0.1, 2}, {0.95, 0.0, 1}, {0.736, 0.1, 8}}) {
    INFO("eta " << c.eta << " b_H " << c.b_H);
    const Vector p = parameters(damped_hertz(), {{"eta", c.eta}, {"b_H", c.b_H}});
    const Settled settled = settle(damped_hertz(), p, rest, {.periods = 2000});
    CHECK(settled.termination == Termination::time);
    CHECK(settled.periods == 2000);
    REQUIRE(settled.suspected_period == c.period);
    const PeriodicOrbit orbit = shoot(damped_hertz(), p, settled.state, settled.suspected_period);
    REQUIRE(orbit.converged());
    CHECK(orbit.period == c.period);
    CHECK(orbit.stable());
    // The distance of the final state from the orbit agrees with the recurrence.
    CHECK((orbit.state - settled.state).lpNorm<Eigen::Infinity>() < 1e-5);
  }
}

TEST_CASE("in chaos no period is suspected") {
  // Largest exponent 0.028 (data/published.toml, undamped Hertz at 0.7114).
  const Settled settled = settle(damped_hertz(), parameters(damped_hertz(), {{"eta", 0.7114}}), rest, {.periods = 500});
  CHECK(settled.termination == Termination::time);
  CHECK(settled.suspected_period == 0);
}

TEST_CASE("the returned state is the one after the transient and not after the test for recurrence") {
  const Vector p = parameters(damped_hertz(), {{"eta", 0.93}, {"b_H", 0.1}});
  const Vector start = vector({0.5, -0.2});
  const Settled settled = settle(damped_hertz(), p, start, {.periods = 7});
  Propagator propagator(damped_hertz(), p);
  Transition transition;
  Vector x = start;
  for (int k = 0; k < 7; ++k) {
    carry(propagator, 0.0, forcing_period(damped_hertz(), p), x, {.sensitivity = Sensitivity::none}, transition);
    x = transition.x1;
  }
  CHECK(settled.state == x);
  CHECK(settled.suspected_period == 0);
}

TEST_CASE("a transient of zero periods tests the recurrence of the start") {
  const Vector p = parameters(damped_hertz(), {{"eta", 0.91}, {"b_H", 0.1}});
  const PeriodicOrbit orbit = shoot(damped_hertz(), p, vector({2.2377, 1.8827}), 2);
  const Settled settled = settle(damped_hertz(), p, orbit.state, {.periods = 0});
  CHECK(settled.periods == 0);
  CHECK(settled.suspected_period == 2);
  CHECK(settled.state == orbit.state);
}

TEST_CASE("a settled run that is interrupted keeps its results so far") {
  int cancel_checks = 0;
  SettleOptions options;
  options.periods = 100;
  options.cancelled = [&] { return ++cancel_checks > 30; };
  const Vector p = parameters(damped_hertz());
  const Settled settled = settle(damped_hertz(), p, rest, options);
  CHECK(settled.termination == Termination::interrupted);
  CHECK(settled.periods == 30);
  CHECK(settled.suspected_period == 0);
  CHECK(settled.state == settle(damped_hertz(), p, rest, {.periods = 30, .max_period = 0}).state);
}

TEST_CASE("misuse of settle is refused in a sentence") {
  CHECK_THROWS_WITH(settle(damped_hertz(), parameters(damped_hertz()), rest, {.periods = -1}),
                    "settle is -1 periods; allowed is 0 or more");
  const HybridSystem rigid = make_oscillator("linear", "newton");
  CHECK_THROWS_WITH(settle(rigid, parameters(rigid), vector({2.5, 0.0})),
                    "the state (2.5, 0) lies inside the barrier; start on the free side of it");
}

TEST_CASE("an autonomous motion settles in returns and its state lies immediately after one") {
  const HybridSystem system = van_der_pol_stop();
  const Vector p = parameters(system);
  const Settled settled = settle(system, p, vector({0.5, 0.0}), {.periods = 100});
  CHECK(settled.termination == Termination::time);
  CHECK(settled.periods == 100);
  CHECK(settled.suspected_period == 1);
  const PeriodicOrbit orbit = shoot(system, p, std::vector<Vector>{vector({-1.5, 0.0})}, 1, {}, 5.0);
  REQUIRE(orbit.events.size() == 1);
  CHECK((settled.state - orbit.events.front().x_plus).norm() < 1e-10);
}

TEST_CASE("settling on a sticking orbit works") {
  const HybridSystem rigid = make_oscillator("linear", "newton");
  const Vector p = parameters(rigid, {{"k_r", 0.5}, {"eta", 0.4}, {"r", 0.5}});
  const Settled settled = settle(rigid, p, rest, {.periods = 50});
  CHECK(settled.termination == Termination::time);
  CHECK(settled.suspected_period == 1);
}
