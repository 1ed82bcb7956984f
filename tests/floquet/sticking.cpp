// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits that chatter and stick (Newton's law, k_r < 1, low frequency): found, with multipliers that are exactly zero.
#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"

#include <catch2/catch.hpp>

#include <limits>

using namespace graze;
using namespace graze::support;

namespace {

const HybridSystem& rigid() {
  static const HybridSystem system = make_oscillator("linear", "newton");
  return system;
}

PeriodicOrbit sticking_orbit(double k_r) {
  const Vector p = parameters(rigid(), {{"k_r", k_r}, {"eta", 0.4}, {"r", 0.5}});
  const Settled settled = settle(rigid(), p, Vector::Zero(2), {.periods = 20});
  return shoot(rigid(), p, settled.state, 1);
}

}  // namespace

TEST_CASE("a sticking orbit is found with both multipliers exactly zero") {
  for (const double k_r : {0.5, 0.3, 0.0}) {
    INFO("k_r " << k_r);
    const PeriodicOrbit orbit = sticking_orbit(k_r);
    REQUIRE(orbit.newton.status == NewtonStatus::converged);
    CHECK(orbit.period == 1);
    CHECK(orbit.admissible == Admissibility::admissible);
    CHECK(orbit.checks.residual < 1e-13);
    REQUIRE(orbit.multipliers.valid);
    for (std::size_t i = 0; i < 2; ++i) {
      CHECK(orbit.multipliers.values[i] == 0.0);
      CHECK(orbit.multipliers.exponents[i] == -std::numeric_limits<double>::infinity());
    }
    CHECK(orbit.stable());
    CHECK(orbit.checks.liouville == -1.0);
  }
}

TEST_CASE("the events of a sticking orbit tell where it sticks and where it is released") {
  const PeriodicOrbit orbit = sticking_orbit(0.5);
  REQUIRE(orbit.converged());
  int sticks = 0, releases = 0;
  for (const EventRecord& event : orbit.events) {
    if (event.kind == EventKind::stick) ++sticks;
    if (event.kind != EventKind::release) continue;
    ++releases;
    // Where the pressing force xi cos(eta t) - r falls through zero.
    CHECK(event.t == Approx(std::acos(0.5) / 0.4).epsilon(1e-13));
    CHECK(event.x_plus[0] == 0.5);
    CHECK(event.x_plus[1] == 0.0);
  }
  CHECK(sticks == 1);
  CHECK(releases == 1);
}

TEST_CASE("a sticking orbit away from the published parameters is released where the force falls below the clearance") {
  const Vector p = parameters(rigid(), {{"k_r", 0.6}, {"eta", 0.3}, {"r", 1.0}, {"b", 0.1}, {"xi", 1.7}});
  const Settled settled = settle(rigid(), p, Vector::Zero(2), {.periods = 20});
  const PeriodicOrbit orbit = shoot(rigid(), p, settled.state, 1);
  REQUIRE(orbit.converged());
  bool released = false;
  for (const EventRecord& event : orbit.events) {
    if (event.kind != EventKind::release) continue;
    released = true;
    CHECK(event.t == Approx(std::acos(1.0 / 1.7) / 0.3).epsilon(1e-13));
    CHECK(event.x_plus[0] == 1.0);
    CHECK(event.x_plus[1] == 0.0);
  }
  CHECK(released);
  CHECK(orbit.multipliers.values[0] == 0.0);
  CHECK(orbit.multipliers.values[1] == 0.0);
}

TEST_CASE("where the force never presses the mass against the barrier no orbit sticks") {
  // xi = r: the pressing force touches zero at phase 0 and is negative elsewhere.
  const Vector p = parameters(rigid(), {{"k_r", 0.5}, {"eta", 0.4}, {"r", 1.0}});
  const Settled settled = settle(rigid(), p, Vector::Zero(2), {.periods = 50});
  const PeriodicOrbit orbit = shoot(rigid(), p, settled.state, 1);
  REQUIRE(orbit.converged());
  for (const EventRecord& event : orbit.events) CHECK(event.kind == EventKind::impact);
  CHECK(orbit.checks.liouville >= 0.0);
  CHECK(orbit.multipliers.values[1] != 0.0);
}

TEST_CASE("the impacts of a chattering series shrink by the coefficient of restitution") {
  const PeriodicOrbit orbit = sticking_orbit(0.5);
  REQUIRE(orbit.converged());
  CHECK(orbit.impacts >= 10);
  for (const EventRecord& event : orbit.events)
    if (event.kind == EventKind::impact) CHECK(event.exit_speed == Approx(0.5 * event.normal_speed).epsilon(1e-12));
}

TEST_CASE("the search finds a sticking orbit once") {
  const Vector p = parameters(rigid(), {{"k_r", 0.5}, {"eta", 0.4}, {"r", 0.5}});
  const SearchResult result = search_orbits(rigid(), p, 1, {.patience = 200});
  REQUIRE(result.orbits.size() == 1);
  CHECK(same_orbit(result.orbits[0], sticking_orbit(0.5), 1e-10));
  CHECK(result.complete);
}

TEST_CASE("a mass held against its stop for good: a disturbance is forgotten by impacts that lose energy, else damped") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector held{{-2.0, 0.0}};
  const PeriodicOrbit forgetful = shoot(system, parameters(system, {{"r", -2.0}, {"k_r", 0.5}, {"xi", 0.3}}), held, 1);
  REQUIRE(forgetful.converged());
  CHECK(forgetful.impacts == 0);
  REQUIRE(forgetful.multipliers.valid);
  for (const auto& mu : forgetful.multipliers.values) CHECK(mu == 0.0);
  const PeriodicOrbit lossless = shoot(system, parameters(system, {{"r", -2.0}, {"k_r", 1.0}, {"xi", 0.3}}), held, 1);
  REQUIRE(lossless.multipliers.valid);
  CHECK(lossless.stable());
  CHECK(lossless.rests);
  // Of a bouncing mass: speed and height at e^(-2 b t / 3) and e^(-4 b t / 3).
  CHECK(lossless.multipliers.exponents[0] == Approx(-2.0 * 0.05 / 3.0).epsilon(1e-12));
  CHECK(lossless.multipliers.exponents[1] == Approx(-4.0 * 0.05 / 3.0).epsilon(1e-12));
}

TEST_CASE("strong damping: a multiplier far below the rounding of its matrix is that of Liouville's identity") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b", 5.0}, {"eta", 0.95}});
  const PeriodicOrbit orbit = shoot(system, p, Vector{{0.0, 0.0}}, 1);
  REQUIRE(orbit.converged());
  REQUIRE(orbit.multipliers.values.size() == 2);
  // exp((-b +- sqrt(b^2 - 1)) T)
  const double T = forcing_period(system, p), root = std::sqrt(24.0);
  CHECK(orbit.multipliers.values[0].real() == Approx(std::exp((-5.0 + root) * T)).epsilon(1e-13));
  CHECK(orbit.multipliers.values[1].real() == Approx(std::exp((-5.0 - root) * T)).epsilon(1e-11));
  CHECK(orbit.checks.liouville == -1.0);  // the entries no longer hold the determinant: nothing to compare
}
