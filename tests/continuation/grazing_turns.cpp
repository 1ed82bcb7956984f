// SPDX-License-Identifier: GPL-3.0-or-later
// The families of several turns that begin on a hard grazing, to first order in the speeds. One of them always does.
#include <graze/continuation/conditions/grazing_edge.hpp>
#include <graze/continuation/conditions/grazing_turns.hpp>

#include "support/grazing_families.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

using namespace graze;

namespace {

struct Oscillator {
  TurnResponse response;
  Eigen::Matrix2d turn;
  double k_r;
};

/// A random map of deviations over one turn, and the kick of an impact with restitution k_r.
Oscillator random_oscillator(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Oscillator out;
  out.k_r = 0.5 * (1.0 + uniform(random));
  out.turn << 2.0 * uniform(random), 2.0 * uniform(random), 2.0 * uniform(random), 2.0 * uniform(random);
  out.response = {out.turn, Vector{{1.0, 0.0}}, Vector{{0.0, -(1.0 + out.k_r)}}};
  return out;
}

}  // namespace

TEST_CASE("beyond a grazing with one touch there is exactly one orbit of the same period") {
  // h_top = -R_1 v: for either sign of R_1 one side has v > 0. For the linear oscillator it is the sign of -sin(w T).
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const Oscillator oscillator = random_oscillator(random);
    const int side = side_of_family(oscillator.response, 1, {0});
    REQUIRE(side != 0);
    CHECK(side == support::side_of_family(oscillator.turn, oscillator.k_r, 1, 1));
  }
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (int i = 0; i < 2000; ++i) {
    const double damping = 0.3 * uniform(random), w = std::sqrt(1.0 - damping * damping), T = 0.1 + 20.0 * uniform(random);
    const double decay = std::exp(-damping * T), c = std::cos(w * T), s = std::sin(w * T) / w;
    Oscillator oscillator = random_oscillator(random);
    oscillator.response.turn << decay * (c + damping * s), decay * s, -decay * s, decay * (c - damping * s);
    CHECK(side_of_family(oscillator.response, 1, {0}) == (s > 0.0 ? 1 : -1));
  }
}

TEST_CASE("each family with the weak impact in some of the turns is counted once") {
  std::mt19937 random(2);
  int met = 0;
  for (int i = 0; i < 60; ++i) {
    const Oscillator oscillator = random_oscillator(random);
    for (int turns = 4; turns <= 7; ++turns) {
      // All choices of turns, up to rotation. The count here marks all rotations of a choice and does not use the least
      // rotation.
      int expected = 0;
      std::vector<bool> seen(std::size_t{1} << turns);
      for (unsigned set = 1; set < (1u << turns); ++set) {
        if (seen[set]) continue;
        int rotations = 0;
        unsigned turned = set;
        do {
          seen[turned] = true;
          turned = ((turned << 1) | (turned >> (turns - 1))) & ((1u << turns) - 1);
          ++rotations;
        } while (turned != set);
        std::vector<int> struck;
        for (int k = 0; k < turns; ++k)
          if (set >> k & 1u) struck.push_back(k);
        const int count = static_cast<int>(struck.size());
        if (rotations < turns || count < 2 || count > turns - 2) continue;
        expected += support::side_of_family(oscillator.turn, oscillator.k_r, turns, struck) != 0 ? 1 : 0;
      }
      CHECK(families_in_some_turns(oscillator.response, turns) == expected);
      met += expected;
    }
  }
  CHECK(met > 100);
}

TEST_CASE("an orbit at its grazing is reduced to its least period, with the duration of an autonomous one") {
  // Its nodes repeat after half the orbit.
  const Vector a{{1.0, 2.0}}, b{{3.0, 4.0}};
  const double duration = 5.0, value = 0.7;
  for (const bool autonomous : {false, true}) {
    INFO(autonomous);
    PeriodicOrbit orbit;
    orbit.period = 2;
    orbit.duration = duration;
    orbit.nodes = {a, b, a, b};
    orbit.state = a;
    orbit.states = {a, a};
    if (autonomous) orbit.multipliers.section = Section::autonomous;
    LocatedGrazing grazing;
    grazing.u = autonomous ? Vector{{1, 2, 3, 4, 1, 2, 3, 4, duration, value}} : Vector{{1, 2, 3, 4, 1, 2, 3, 4, value}};
    grazing.family_dp = grazing.u;
    CHECK(to_least_period(orbit, grazing) == 1);
    CHECK(orbit.period == 1);
    CHECK(orbit.duration == 0.5 * duration);
    CHECK(orbit.nodes == std::vector<Vector>{a, b});
    const Vector expected = autonomous ? Vector{{1, 2, 3, 4, 0.5 * duration, value}} : Vector{{1, 2, 3, 4, value}};
    REQUIRE(grazing.u.size() == expected.size());
    CHECK(grazing.u == expected);
    CHECK(grazing.family_dp == expected);
  }
}
