// SPDX-License-Identifier: GPL-3.0-or-later
// The classifier recognises motions that approach a known orbit before they reach its trapping region. Also tested: the set of
// visited cells behind it.
#include <graze/floquet/basins/attractor_classifier.hpp>
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"

#include <catch2/catch.hpp>

#include <random>
#include <unordered_set>

using namespace graze;
using namespace graze::support;

TEST_CASE("a motion that approaches a known orbit is recognised by its decreasing distance") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  Vector p = default_parameters(system.parameters);
  p[oscillator_parameter::eta] = 0.95;
  const PeriodicOrbit orbit = shoot(system, p, vector({1.2, 0.4}), 1);
  REQUIRE(orbit.stable());
  KnownAttractor known;
  known.type = AttractorType::periodic;
  known.orbit = trapping_region(system, p, orbit.state, 1);
  AttractorClassifier attractors;
  attractors.add(known);
  const double slowest = std::abs(orbit.multipliers.values.front());
  const Vector start = orbit.state + vector({1e-3, -2e-3});
  const auto nearing = attractors.nearing(start, 1);
  REQUIRE(nearing);
  CHECK(nearing->attractor == 0);
  CHECK(nearing->distance == Approx(2e-3));
  CHECK(nearing->periods == std::ceil(std::log(0.5) / std::log(slowest)));  // closed form: |mu|^n <= 1/2
  // The distance has decreased after that time. It has not at the start, nor after a step away.
  Propagator propagator(system, p);
  Transition transition;
  Vector x = start;
  for (int k = 0; k < static_cast<int>(nearing->periods); ++k) {
    carry(propagator, 0.0, forcing_period(system, p), x, {}, transition);
    x = transition.x1;
  }
  CHECK(attractors.has_come_closer(*nearing, x));
  CHECK_FALSE(attractors.has_come_closer(*nearing, start));
  CHECK_FALSE(attractors.has_come_closer(*nearing, Vector(orbit.state + 2.0 * (start - orbit.state))));
  // On the orbit the distance cannot decrease further.
  const auto there = attractors.nearing(Vector(orbit.state + vector({1e-12, 0.0})), 1);
  REQUIRE(there);
  CHECK(attractors.has_come_closer(*there, orbit.state));
  // A return after three periods may belong to an orbit of period 1. A distant state has no orbit nearby, and an orbit without
  // a rate never counts.
  CHECK(attractors.nearing(start, 3));
  CHECK_FALSE(attractors.nearing(Vector(orbit.state + vector({1.0, 0.0})), 1));
  known.orbit.rate = 1.0;
  AttractorClassifier without_rate;
  without_rate.add(known);
  CHECK_FALSE(without_rate.nearing(start, 1));
  // A motion that returns after one period does not approach an orbit of period 2.
  KnownAttractor twice = known;
  twice.orbit.rate = 0.5;
  twice.orbit.centres.push_back(twice.orbit.centres.front());
  AttractorClassifier of_period_2;
  of_period_2.add(twice);
  CHECK_FALSE(of_period_2.nearing(start, 1));
  CHECK(of_period_2.nearing(start, 2));
}

TEST_CASE("a set of cells contains exactly the inserted cells") {
  std::mt19937_64 random(3);
  CellSet cells;
  std::unordered_set<std::uint64_t> expected;
  for (int i = 0; i < 20000; ++i) {
    // Neighbouring numbers, as for cells, and numbers far apart; many are inserted twice.
    const std::uint64_t number = 1 + (i % 3 == 0 ? random() % 4000 : (random() % 50) * 1009 + 1017000);
    CHECK(cells.insert(number) == expected.insert(number).second);
  }
  REQUIRE(cells.size() == expected.size());
  int wrong = 0;
  for (std::uint64_t number = 1; number < 1100000; ++number) wrong += cells.holds(number) != (expected.count(number) > 0) ? 1 : 0;
  CHECK(wrong == 0);
}
