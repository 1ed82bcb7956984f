// SPDX-License-Identifier: GPL-3.0-or-later
// Motions in a laminar phase: near an unstable orbit, on it, on the way to a stable orbit, in narrow bands of chaos, and
// intermittently.
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/attractor/laminar_phase.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>

using namespace graze;
using namespace graze::support;

namespace {

/// Tests a sequence of positions, forwards from its element 1000 and then again from element 0.
LaminarPhase observed_phase(const std::function<double(int)>& x, int period, std::int64_t longest_escape = 0) {
  const auto state = [&](int k) { return vector({x(k), 0.0}); };
  LaminarPhase watch(state(1000), period, 2e-3, longest_escape);
  for (int k = 1001; watch.open(); ++k) watch.see(Termination::time, state(k));
  watch.look_back(state(0), 1000);
  for (int k = 1; watch.open(); ++k) watch.see(Termination::time, state(k));
  return watch;
}

}  // namespace

TEST_CASE("laminar phase: a slow departure from or approach to an orbit continues and was laminar all the time") {
  const auto leaving = [](int k) { return 1.0 + 1e-4 * std::exp(0.002 * k) * (k % 2 ? -1.0 : 1.0); };
  for (const LaminarPhase& watch :
       {observed_phase(leaving, 2), observed_phase([](int k) { return 1.0 + 0.5 * std::exp(-0.003 * k); }, 1)}) {
    CHECK(watch.goes_on());
    CHECK(watch.always());
    CHECK_FALSE(watch.on_an_orbit());
  }
  const LaminarPhase on_orbit = observed_phase([](int) { return 1.0; }, 1);
  CHECK(on_orbit.goes_on());
  CHECK(on_orbit.on_an_orbit());
}

TEST_CASE("laminar phase: a motion next to an orbit is observed for less time than chaos") {
  const auto periods = [](const std::function<double(int)>& x) {
    LaminarPhase watch(vector({x(0), 0.0}), 2, 2e-3, 10000);
    int k = 0;
    while (watch.open()) watch.see(Termination::time, vector({x(++k), 0.0}));
    watch.look_back(vector({x(0), 0.0}), 100);
    CHECK(watch.goes_on() == watch.on_an_orbit());
    return k;
  };
  // After 300 periods the motion is within 1e-6 of an orbit, alternating between its two sides.
  const auto settles = [](int k) { return (k % 2 ? 1.0 : 2.0) + 1e-4 * std::exp(-0.0154 * k) * (k % 4 < 2 ? 1.0 : -1.0); };
  CHECK(periods(settles) > 300);
  CHECK(periods(settles) < 500);
  // Chaos in narrow bands gets equally close from time to time.
  const auto bands = [](int k) { return (k % 2 ? 1.0 : 2.0) + 3e-4 * std::exp(-0.1 * (k % 100)) * (k % 4 < 2 ? 1.0 : -1.0); };
  CHECK(periods(bands) == 10002);
}

TEST_CASE("laminar phase: chaos that returns continues without having been laminar and a motion that leaves at once is none") {
  const LaminarPhase back = observed_phase([](int k) { return k < 900 ? std::cos(1.0 * k * k) : 0.5; }, 1);
  CHECK(back.goes_on());
  CHECK_FALSE(back.always());
  const LaminarPhase away = observed_phase([](int k) { return k < 1050 ? 0.5 : std::cos(1.0 * k * k); }, 1);
  CHECK_FALSE(away.goes_on());
  LaminarPhase failed(vector({0.0, 0.0}), 1, 2e-3);
  failed.see(Termination::grazing, vector({0.0, 0.0}));
  CHECK_FALSE(failed.open());
}

TEST_CASE("laminar phase: a motion that stays longer than any escape from an orbit stays for good") {
  const auto bands = [](int k) { return (k % 2 ? 1.0 : 2.0) + 3e-4 * std::cos(1.0 * k * k); };
  CHECK(observed_phase(bands, 2).goes_on());
  CHECK_FALSE(observed_phase(bands, 2, 500).goes_on());
  const auto bursts = [&](int k) { return k == 1400 ? 0.0 : bands(k); };
  CHECK(observed_phase(bursts, 2, 500).goes_on());
  // On the orbit itself: rounding would not move it away either.
  CHECK(observed_phase([](int) { return 1.0; }, 1, 500).goes_on());
}

TEST_CASE("attractors: a start on an unstable orbit ends on an attractor") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b", 0.05}, {"eta", 0.9194}, {"r", 2.0}, {"k_H", 100.0}, {"b_H", 0.1}});
  const PeriodicOrbit orbit = shoot(system, p, vector({2.05, 1.39}), 1);
  REQUIRE(orbit.converged());
  REQUIRE_FALSE(orbit.stable());
  AttractorOptions options;
  options.recurrence = GENERATE(0.0, 1e-4);
  const Attractor attractor = find_attractor(system, p, orbit.state, options);
  CHECK(attractor.type == AttractorType::periodic);
  CHECK(attractor.period == 2);
  CHECK(attractor.exponents[0] < 0.0);
}
