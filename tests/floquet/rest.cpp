// SPDX-License-Identifier: GPL-3.0-or-later
// A mass at rest on a preloaded stop. It is recognised by every method, for impacts with and without energy loss.
#include <graze/floquet/attractor/settle.hpp>
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/floquet/basins/basins.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/rest.hpp>

#include "support/checks.hpp"
#include "support/each_attractor.hpp"
#include "support/newton_oscillator.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <limits>

using namespace graze;
using namespace graze::support;

namespace {

constexpr double minus_infinity = -std::numeric_limits<double>::infinity();

/// A preload of at least 0.3 acts on the stop at r = -1.
Vector pressed(double k_r, double b = 0.02) {
  return parameters(newton_oscillator(), {{"k_r", k_r}, {"b", b}, {"xi", 0.7}, {"eta", 0.8}, {"r", -1.0}});
}

const Vector rest = Vector{{-1.0, 0.0}};

AttractorOptions quick() {
  AttractorOptions options;
  options.transient = 200;
  options.recurrence = 1e-4;
  options.periods_on_orbit = 0;
  return options;
}

}  // namespace

TEST_CASE("a mass on a preloaded stop rests forever only where the preload never vanishes") {
  for (const double xi : {0.0, 0.5, 0.999, -0.999, 1.001, -1.001, 1.5}) {
    INFO("xi " << xi);
    Vector p = pressed(0.8);
    p[oscillator_parameter::xi] = xi;
    Propagator propagator(newton_oscillator(), p);
    CHECK(permanent_rest(propagator, rest).has_value() == (std::abs(xi) < 1.0));
  }
}

TEST_CASE("rest is an attractor with exponents minus infinity and not undecided with exponent 0") {
  for (const double k_r : {0.0, 0.5, 0.8, 0.99})
    for (const bool in_lanes : {true, false}) {
      INFO("k_r " << k_r << ", lanes " << in_lanes);
      AttractorOptions options = quick();
      if (!in_lanes) options.lyapunov.flow.kind = FlowKind::alone;
      const Attractor found = find_each_attractor(newton_oscillator(), {{pressed(k_r), rest}}, options).front();
      REQUIRE(found.type == AttractorType::periodic);
      CHECK(found.rests);
      CHECK(found.state == rest);
      CHECK(found.exponents == std::vector<double>{minus_infinity, minus_infinity});
    }
}

TEST_CASE("the time average of a mass at rest is minus infinity too") {
  AttractorOptions options;
  options.transient = 20;
  options.periods_on_orbit = 100;
  const Attractor found = find_attractor(newton_oscillator(), pressed(0.8), rest, options);
  CHECK(found.time_average.exponents == std::vector<double>{minus_infinity, minus_infinity});
}

TEST_CASE("with elastic impacts a disturbance of rest decays by damping alone at -2b/3 and -4b/3") {
  constexpr double b = 0.02;
  const Vector p = pressed(1.0, b);
  const Attractor found = find_each_attractor(newton_oscillator(), {{p, rest}}, quick()).front();
  REQUIRE(found.type == AttractorType::periodic);
  CHECK(found.rests);
  REQUIRE(found.exponents.size() == 2);
  CHECK(found.exponents[0] == Approx(-2.0 * b / 3.0).epsilon(1e-12));
  CHECK(found.exponents[1] == Approx(-4.0 * b / 3.0).epsilon(1e-12));
  // The speed of a bouncing mass, from a simulation, at the same forcing phase: there the preload is the same.
  Propagator propagator(newton_oscillator(), p);
  const double T = forcing_period(newton_oscillator(), p);
  Vector x{{-1.0, -0.01}};
  Transition run;
  std::vector<double> speeds;
  constexpr int periods = 10;
  for (int k = 0; k <= periods; ++k) {
    carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none, .keep_events = true}, run);
    REQUIRE(run.termination == Termination::time);
    speeds.push_back(run.events.front().normal_speed);
    x = run.x1;
  }
  CHECK(std::log(speeds.back() / speeds.front()) / (periods * T) == Approx(-2.0 * b / 3.0).epsilon(0.02));
}

TEST_CASE("a mass that bounces lower and lower on its preloaded stop reaches rest and is not lost") {
  for (const double k_r : {1.0, 0.9999, 0.9})
    for (const bool in_lanes : {true, false}) {
      INFO("k_r " << k_r << ", lanes " << in_lanes);
      AttractorOptions options = quick();
      if (!in_lanes) options.lyapunov.flow.kind = FlowKind::alone;
      const Attractor found = find_each_attractor(newton_oscillator(), {{pressed(k_r), Vector{{-1.5, 0.2}}}}, options).front();
      CHECK(found.termination == Termination::time);
      CHECK(found.rests);
      CHECK(found.state == rest);
    }
  const Settled settled = settle(newton_oscillator(), pressed(1.0), Vector{{-1.5, 0.2}}, {.periods = 1000});
  CHECK(settled.termination == Termination::time);
  CHECK(settled.state == rest);
}

TEST_CASE("starts that end at rest are recognised at once") {
  for (const double k_r : {0.8, 1.0}) {
    INFO("k_r " << k_r);
    Matrix starts(2, 64);
    for (Eigen::Index i = 0; i < starts.cols(); ++i) {
      const Eigen::Index column = i % 8, row = i / 8;
      starts.col(i) << -1.0 - 0.1 * static_cast<double>(column), 0.1 * static_cast<double>(row) - 0.4;
    }
    const Basins basins = find_attractors(newton_oscillator(), pressed(k_r), starts, {});
    REQUIRE(basins.attractors.size() == 1);
    CHECK(basins.attractors.front().attractor.rests);
    CHECK(basins.attractors.front().count == 64);
    CHECK(basins.periods < 64 * 100);  // of up to 1000 for a start
  }
}

TEST_CASE("without dissipation rest is neutral") {
  const Attractor found = find_attractor(newton_oscillator(), pressed(1.0, 0.0), rest, {.transient = 10, .periods_on_orbit = 0});
  CHECK(found.rests);
  CHECK(found.conservative);
  CHECK(found.motion == ConservativeMotion::neutral);
  CHECK(found.exponents == std::vector<double>{0.0, 0.0});
}
