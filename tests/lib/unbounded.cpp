// SPDX-License-Identifier: GPL-3.0-or-later
// Motions that grow without bound: every reported escape is one, and no bounded motion is reported.
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/transition.hpp>
#include <graze/lib/motion/unbounded.hpp>

#include "support/checks.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <numbers>

using namespace graze;
using namespace graze::support;

TEST_CASE("a motion beyond the saddle of a softening spring is reported as an escape and no bounded motion is") {
  int escaped = 0, bounded = 0;
  for (const char* law : {"newton", "linear", "hertz"}) {
    const HybridSystem system = make_oscillator("cantilever", law);
    const Vector p = parameters(system, {{"b", 0.05}, {"beta", -1.0}, {"xi", 0.2}, {"eta", 0.8}, {"r", 0.5}});
    const double T = forcing_period(system, p);
    for (double x = -1.5; x < 0.5; x += 0.125)
      for (const double v : {-0.5, -0.1, 0.1, 0.3}) {
        INFO(law << " x " << x << " v " << v);
        // The general integrator has no special treatment of springs.
        const Trajectory run = simulate(system, p, 0.0, vector({x, v}), {.t_end = 40.0 * T}, {.kind = FlowKind::general});
        const bool stays = run.termination == Termination::time;
        if (escapes(system, p, 0, vector({x, v}))) {
          CHECK(!stays);
          CHECK(std::abs(run.segments.back().x1[0]) > 1e3);
        }
        Propagator propagator(system, p);
        Transition transition;
        carry(propagator, 0.0, 40.0 * T, vector({x, v}), {.sensitivity = Sensitivity::none}, transition);
        CHECK(transition.termination == (stays ? Termination::time : Termination::escape));
        if (!stays) {
          ++escaped;
          continue;
        }
        ++bounded;
        for (const Segment& segment : run.segments) CHECK(!escapes(system, p, segment.mode, segment.x1));
      }
  }
  CHECK(escaped > 20);
  CHECK(bounded > 20);
}

TEST_CASE("a softening spring escapes through a soft stop where its force exceeds that of the stop") {
  for (const char* law : {"linear", "hertz"}) {
    const HybridSystem system = make_oscillator("cantilever", law);
    const Vector p = parameters(system, {{"b", 0.05}, {"beta", -1.0}, {"xi", 0.2}, {"eta", 0.8}, {"r", 0.5}});
    const std::size_t contact = initial_mode(system, 0.0, vector({50.0, 1.0}), p);
    CHECK(contact != 0);
    CHECK(escapes(system, p, contact, vector({50.0, 1.0})));
    CHECK(!escapes(system, p, contact, vector({50.0, -1.0})));
    CHECK(!escapes(system, p, contact, vector({0.6, 1.0})));
  }
  // In front of a hard stop there is no escape.
  const HybridSystem hard = make_oscillator("cantilever", "newton");
  const Vector p = parameters(hard, {{"beta", -1.0}, {"xi", 0.2}, {"r", 100.0}});
  CHECK(!escapes(hard, p, 0, vector({50.0, 1.0})));
  CHECK(escapes(hard, p, 0, vector({-50.0, -1.0})));
}

TEST_CASE("undamped resonance adds pi xi over eta squared to the amplitude each period until the barrier is met") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const auto with = [&](double b, double eta) { return parameters(system, {{"b", b}, {"eta", eta}, {"r", 50.0}, {"xi", -1.5}}); };
  const Vector p = with(0.0, 1.0), start = vector({0.3, -0.4});
  const double said = resonant_periods(system, p, start), each = 1.5 * std::numbers::pi;
  CHECK(said == std::floor((50.0 - 0.5) / each));
  const Trajectory run = simulate(system, p, 0.0, start, {.t_end = said * 2.0 * std::numbers::pi}, {.kind = FlowKind::general});
  CHECK(run.events.empty());
  CHECK(std::abs(run.x.norm() - said * each) < 1.0);
  const Trajectory beyond = simulate(system, p, 0.0, start, {.t_end = (said + 2.0) * 2.0 * std::numbers::pi});
  CHECK(!beyond.events.empty());
  CHECK(resonant_periods(system, with(1e-9, 1.0), start) == 0.0);
  CHECK(resonant_periods(system, with(0.0, 1.0 + 1e-12), start) == 0.0);
}
