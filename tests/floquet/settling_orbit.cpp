// SPDX-License-Identifier: GPL-3.0-or-later
// What a motion is settling on where chaos and a stable orbit stand side by side.
#include <graze/floquet/settle.hpp>
#include <graze/floquet/settling_orbit.hpp>
#include <graze/lib/oscillator.hpp>

#include "support/checks.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

/// At these parameters there are chaos (of a first exponent of 0.010) and a stable orbit 12/12, close to it and of a small basin.
const HybridSystem& system_with_both() {
  static const HybridSystem system = make_oscillator("linear", "newton");
  return system;
}
Vector with_both() {
  return parameters(system_with_both(), {{"b", 0.05}, {"xi", 1.0}, {"eta", 0.7396}, {"r", 2.0}, {"k_r", 1.0}});
}
const Vector chaotic = vector({1.8100099058373453, -0.86296494178271788});
const Vector beside_orbit = vector({1.81898998, -0.8426422});

/// After so many periods.
Vector later(const Vector& state, int periods) {
  SettleOptions options;
  options.periods = periods;
  options.max_period = 0;
  return settle(system_with_both(), with_both(), state, options).state;
}

}  // namespace

TEST_CASE("a motion that passes by a stable orbit is not settling on it") {
  // It comes closer for twelve periods to an orbit whose multiplier halves distances twelve times faster.
  const auto orbit = settling_orbit(system_with_both(), with_both(), beside_orbit, 64);
  REQUIRE(orbit);
  CHECK(orbit->period == 12);
  CHECK(std::abs(orbit->multipliers.values.front()) < 0.1);
  const auto distance = [&](const Vector& x) {
    double least = 1e9;
    for (const Vector& state : orbit->states) least = std::min(least, (state - x).lpNorm<Eigen::Infinity>());
    return least;
  };
  CHECK(distance(later(beside_orbit, 240)) < 1e-9);
  const double before = distance(chaotic);
  CHECK(before < 0.1);
  CHECK(distance(later(chaotic, 12)) < 0.75 * before);
  CHECK(distance(later(chaotic, 1200)) > 1e-3);  // it is still in chaos
  CHECK_FALSE(settling_orbit(system_with_both(), with_both(), chaotic, 64));
  CHECK_FALSE(settling_orbit(system_with_both(), with_both(), chaotic, 12));
}

TEST_CASE("motions that end, or whose tangents grow for long, are not worth a look") {
  const Vector inside_barrier = vector({2.5, 0.0});
  const std::vector<Vector> states = {chaotic, beside_orbit, later(chaotic, 100), later(beside_orbit, 5), inside_barrier};
  const std::vector<Vector> left = that_may_settle(system_with_both(), with_both(), states);
  REQUIRE(left.size() == 2);
  CHECK(left[0] == states[1]);
  CHECK(left[1] == states[3]);
}
