// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits that chatter and stick (Newton's law, k_r < 1, low frequency). Their multipliers are exactly zero.
#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/floquet/exponents/lyapunov.hpp>
#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/rest.hpp>

#include "support/checks.hpp"
#include "support/newton_oscillator.hpp"
#include "support/pressed_mass.hpp"
#include "support/system_texts.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

PeriodicOrbit sticking_orbit(double k_r) {
  const Vector p = parameters(newton_oscillator(), {{"k_r", k_r}, {"eta", 0.4}, {"r", 0.5}});
  const Settled settled = settle(newton_oscillator(), p, Vector::Zero(2), {.periods = 20});
  return shoot(newton_oscillator(), p, settled.state, 1);
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

TEST_CASE("the events of a sticking orbit include the sticking and the release") {
  const PeriodicOrbit orbit = sticking_orbit(0.5);
  REQUIRE(orbit.converged());
  int sticks = 0, releases = 0;
  for (const EventRecord& event : orbit.events) {
    if (event.kind == EventKind::stick) ++sticks;
    if (event.kind != EventKind::release) continue;
    ++releases;
    // Release: the contact force xi cos(eta t) - r falls through zero.
    CHECK(event.t == Approx(std::acos(0.5) / 0.4).epsilon(1e-13));
    CHECK(event.x_plus[0] == 0.5);
    CHECK(event.x_plus[1] == 0.0);
  }
  CHECK(sticks == 1);
  CHECK(releases == 1);
}

TEST_CASE("a sticking orbit beyond the published parameters is released where the force falls below the clearance") {
  const Vector p = parameters(newton_oscillator(), {{"k_r", 0.6}, {"eta", 0.3}, {"r", 1.0}, {"b", 0.1}, {"xi", 1.7}});
  const Settled settled = settle(newton_oscillator(), p, Vector::Zero(2), {.periods = 20});
  const PeriodicOrbit orbit = shoot(newton_oscillator(), p, settled.state, 1);
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

TEST_CASE("no orbit sticks if the force never presses the mass against the barrier") {
  // xi = r: the contact force touches zero at phase 0 and is negative elsewhere.
  const Vector p = parameters(newton_oscillator(), {{"k_r", 0.5}, {"eta", 0.4}, {"r", 1.0}});
  const Settled settled = settle(newton_oscillator(), p, Vector::Zero(2), {.periods = 50});
  const PeriodicOrbit orbit = shoot(newton_oscillator(), p, settled.state, 1);
  REQUIRE(orbit.converged());
  for (const EventRecord& event : orbit.events) CHECK(event.kind == EventKind::impact);
  CHECK(orbit.checks.liouville >= 0.0);
  CHECK(orbit.multipliers.values[1] != 0.0);
}

TEST_CASE("the impacts of a chattering series shrink by the coefficient of restitution") {
  const PeriodicOrbit orbit = sticking_orbit(0.5);
  REQUIRE(orbit.converged());
  CHECK(orbit.impacts >= 10);
  int impacts = 0;
  for (const EventRecord& event : orbit.events) {
    if (event.kind != EventKind::impact) continue;
    CHECK(event.exit_speed == Approx(0.5 * event.normal_speed).epsilon(1e-12));
    ++impacts;
  }
  CHECK(impacts >= 9);
}

TEST_CASE("the search finds a sticking orbit once") {
  const Vector p = parameters(newton_oscillator(), {{"k_r", 0.5}, {"eta", 0.4}, {"r", 0.5}});
  const SearchResult result = search_orbits(newton_oscillator(), p, 1, {.patience = 200});
  REQUIRE(result.orbits.size() == 1);
  CHECK(same_orbit(result.orbits[0], sticking_orbit(0.5), 1e-10));
  CHECK(result.complete);
}

TEST_CASE("a mass held against its stop forever: a disturbance vanishes with inelastic impacts and is damped otherwise") {
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
  // Speed and height of a bouncing mass decay as e^(-2 b t / 3) and e^(-4 b t / 3).
  CHECK(lossless.multipliers.exponents[0] == Approx(-2.0 * 0.05 / 3.0).epsilon(1e-12));
  CHECK(lossless.multipliers.exponents[1] == Approx(-4.0 * 0.05 / 3.0).epsilon(1e-12));
}

TEST_CASE("strong damping: a multiplier far below the rounding of its matrix follows from Liouville's identity") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b", 5.0}, {"eta", 0.95}});
  const PeriodicOrbit orbit = shoot(system, p, Vector{{0.0, 0.0}}, 1);
  REQUIRE(orbit.converged());
  REQUIRE(orbit.multipliers.values.size() == 2);
  // exp((-b +- sqrt(b^2 - 1)) T)
  const double T = forcing_period(system, p), root = std::sqrt(24.0);
  CHECK(orbit.multipliers.values[0].real() == Approx(std::exp((-5.0 + root) * T)).epsilon(1e-13));
  CHECK(orbit.multipliers.values[1].real() == Approx(std::exp((-5.0 - root) * T)).epsilon(1e-11));
  CHECK(orbit.checks.liouville == -1.0);  // the entries no longer determine the determinant: no comparison
}

namespace {

HybridSystem made(const SystemWriter& writer) { return equations::make_system(writer.system).system; }

/// The orbit on which a motion from this start settles.
PeriodicOrbit orbit_from(const HybridSystem& system, const Vector& start, int settle_for = 200) {
  const Vector p = default_parameters(system.parameters);
  const Settled settled = settle(system, p, start, {.periods = settle_for});
  REQUIRE(settled.termination == Termination::time);
  PeriodicOrbit orbit = shoot(system, p, settled.state, 1);
  REQUIRE(orbit.converged());
  REQUIRE(orbit.multipliers.valid);
  return orbit;
}

/// Masses 1 and 2 that friction holds together: 3 w' = F cos(w t) - 0.2 w - 2 a - b.
SystemWriter pair_held_together() {
  SystemWriter writer;
  writer.system.name = "pair";
  writer.forcing("eta").parameter("eta", "0.7").parameter("mu", "2");
  writer.mechanics({"a", "b"}, {"u", "v"},
                   {{{"1", "0"}, {"0", "2"}}, {{"0.1", "0"}, {"0", "0.1"}}, {{"2", "0"}, {"0", "1"}}, {"cos(eta*t)", "0"}});
  writer.friction("between", "u - v", "1", "mu");
  return writer;
}

}  // namespace

TEST_CASE("dry friction that holds all the time gives a multiplier that is exactly zero (fixed)") {
  const HybridSystem system = made(pair_held_together());
  const PeriodicOrbit orbit = orbit_from(system, vector({0.1, 0.0, 0.0, 0.0}));
  REQUIRE(orbit.events.empty());
  const double T = 2.0 * std::numbers::pi / 0.7, delta = 0.2 / 6.0, omega = std::sqrt(1.0 - delta * delta);
  const auto& mu = orbit.multipliers.values;
  REQUIRE(mu.size() == 4);
  // Their distance is constant, and their common motion is a linear oscillator.
  CHECK(std::abs(mu[0] - std::polar(std::exp(-delta * T), std::abs(std::remainder(omega * T, 2.0 * std::numbers::pi)))) < 1e-11);
  CHECK(std::abs(mu[1] - std::conj(mu[0])) < 1e-15);
  CHECK(mu[2] == 0.0);
  CHECK(orbit.multipliers.exponents[2] == -std::numeric_limits<double>::infinity());
  // That of the distance is trivial.
  CHECK(orbit.multipliers.trivial == 1);
  CHECK(mu[3] == 1.0);
}

TEST_CASE("the response to a disturbance against static friction agrees with the first-order map") {
  // The reference runs slip first, for a time proportional to the disturbance.
  const HybridSystem system = made(pair_held_together());
  const Vector p = default_parameters(system.parameters), start = vector({0.1, 0.3, -0.2, -0.2});
  Propagator propagator(system, p);
  Transition base, moved;
  carry(propagator, 0.0, 5.0, start, {.sensitivity = Sensitivity::state}, base);
  REQUIRE(base.termination == Termination::time);
  REQUIRE(base.event_sequence.empty());
  constexpr double h = 1e-6;
  for (Eigen::Index k = 0; k < 4; ++k) {
    Matrix side(4, 2);
    for (const int sign : {-1, 1}) {
      Vector x = start;
      x[k] += sign * h;
      carry(propagator, 0.0, 5.0, x, {.sensitivity = Sensitivity::none}, moved);
      REQUIRE(moved.termination == Termination::time);
      CHECK(moved.event_sequence.empty() == (k < 2));
      side.col(sign > 0 ? 1 : 0) = moved.x1;
    }
    INFO("state " << k);
    // The slipped distance grows with the square of the disturbance, with its sign: an error proportional to h.
    CHECK(((side.col(1) - side.col(0)) / (2.0 * h) - base.Phi.col(k)).lpNorm<Eigen::Infinity>() < (k < 2 ? 1e-8 : h));
  }
}

TEST_CASE("a mass held by a moving belt follows a change of the belt speed") {
  SystemWriter writer;
  writer.system.name = "belt";
  writer.forcing("eta").parameter("eta", "1").parameter("speed", "0.3").parameter("mu", "2");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {}, {{"0.1"}}, {"0.1*cos(eta*t)"}}).friction("belt", "v - speed", "1", "mu");
  const HybridSystem system = made(writer);
  const Vector p = default_parameters(system.parameters), start = vector({0.2, 0.3});
  Propagator propagator(system, p, {parameter_index(system.parameters, "speed")});
  Transition transition;
  carry(propagator, 0.0, 4.0, start, {.sensitivity = Sensitivity::state_and_parameters}, transition);
  REQUIRE(transition.event_sequence.empty());
  // x = x0 + speed t, for any initial speed of the mass.
  CHECK((transition.Phi - Matrix{{1.0, 0.0}, {0.0, 0.0}}).cwiseAbs().maxCoeff() < 1e-14);
  CHECK((transition.Psi.col(0) - vector({4.0, 1.0})).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("an orbit that slides on a surface all the time has a multiplier that is exactly zero (fixed)") {
  // On y = 0.1 x both fields point to the surface: y' = -+1. Along it x' = cos(t) - x - 0.2 (y' = 0.1 x' there).
  SystemWriter writer;
  writer.system.name = "slide";
  writer.states({"x", "y"}).forcing("eta").parameter("eta", "1");
  writer.mode("below", "x' = cos(eta*t) - x - 0.2; y' = 1").mode("above", "x' = cos(eta*t) - x - 0.2; y' = -1");
  writer.surface("y - 0.1*x", "below", "above", "slide");
  const HybridSystem system = made(writer);
  const PeriodicOrbit orbit = orbit_from(system, vector({0.0, 0.5}), 20);
  REQUIRE(orbit.events.empty());
  CHECK(std::abs(orbit.multipliers.values[0] - std::exp(-2.0 * std::numbers::pi)) < 1e-14);
  CHECK(orbit.multipliers.values[1] == 0.0);
}

TEST_CASE("a mass held by its stop while another one hits its own has two multipliers that are exactly zero (fixed)") {
  const auto writer = [](bool with_held_mass) {
    SystemWriter out;
    out.system.name = "two";
    out.forcing("eta").parameter("eta", "0.8").parameter("k_r", "0.7");
    if (with_held_mass) {
      out.mechanics({"x", "y"}, {"v", "w"},
                    {{{"1", "0"}, {"0", "1"}}, {{"0.1", "0"}, {"0", "0.1"}}, {{"1", "0"}, {"0", "1"}}, {"2", "cos(eta*t)"}});
      out.stop("held", "-x", "newton", {"k_r"});
    } else {
      out.mechanics({"y"}, {"w"}, {{{"1"}}, {{"0.1"}}, {{"1"}}, {"cos(eta*t)"}});
    }
    out.stop("wall", "0.3 - y", "newton", {"k_r"});
    return out;
  };
  const HybridSystem both = made(writer(true)), alone = made(writer(false));
  const PeriodicOrbit two = orbit_from(both, vector({0.0, 0.0, 0.0, 0.0})), one = orbit_from(alone, vector({0.0, 0.0}));
  REQUIRE(!two.events.empty());
  for (std::size_t i = 0; i < 2; ++i)
    CHECK(std::abs(two.multipliers.values[i] - one.multipliers.values[i]) < 1e-10 * std::abs(one.multipliers.values[i]));
  CHECK(two.multipliers.values[2] == 0.0);
  CHECK(two.multipliers.values[3] == 0.0);
}

TEST_CASE("a stop whose gap contains two coordinates leaves two exact zeros, straight or curved (fixed)") {
  // On x = 1/2 + y/20 the motion is that of y alone, with inertia, damping and stiffness J^T M J of J = (1/20, 1).
  const double mass = 1.0 + 0.0025, damping = 0.0005 - 0.01 + 0.1;
  for (const std::string gap : {"0.5 + 0.05*y - x", "0.5 + 0.05*y - 0.01*y^2 - x"}) {
    INFO(gap);
    const HybridSystem system = made(pressed_to(gap));
    const PeriodicOrbit orbit = orbit_from(system, vector({0.5, 0.0, 0.0, 0.0}), 60);
    REQUIRE(orbit.events.empty());
    const auto& mu = orbit.multipliers.values;
    REQUIRE(mu.size() == 4);
    CHECK(mu[2] == 0.0);
    CHECK(mu[3] == 0.0);
    const bool straight = gap.find('^') == std::string::npos;
    if (straight) CHECK(std::norm(mu[0]) == Approx(std::exp(-damping / mass * orbit.duration)).epsilon(1e-10));
    LyapunovOptions options;
    options.max_periods = 400;
    options.aligning = 20;
    options.standard_error = 0.0;
    const LyapunovSpectrum average = lyapunov_spectrum(system, orbit.parameters, orbit.state, options);
    REQUIRE(average.exponents.size() == 4);
    CHECK(average.exponents[2] == -std::numeric_limits<double>::infinity());
    CHECK(average.exponents[3] == -std::numeric_limits<double>::infinity());
    CHECK(average.exponents[0] + average.exponents[1] ==
          Approx(orbit.multipliers.exponents[0] + orbit.multipliers.exponents[1]).epsilon(1e-9));
    // The state keeps to the stop.
    const double y = orbit.state[1];
    CHECK(std::abs(0.5 + 0.05 * y - (straight ? 0.0 : 0.01 * y * y) - orbit.state[0]) < 1e-14);
  }
}

TEST_CASE("a start beside the constraint of a held mass is moved onto it, a start far from it is not") {
  const HybridSystem system = made(pressed_to("0.5 + 0.05*y - 0.01*y^2 - x"));
  const Vector p = default_parameters(system.parameters);
  const auto on = [](double y, double u) { return vector({0.5 + 0.05 * y - 0.01 * y * y, y, (0.05 - 0.02 * y) * u, u}); };
  const Vector exact = on(0.3, -0.2);
  const std::optional<std::size_t> mode = mode_at(system, 0.0, exact, p);
  REQUIRE(mode);
  REQUIRE(system.modes[*mode].constraints.size() == 2);
  Vector beside = exact + vector({1e-5, 0.0, -2e-5, 0.0});
  REQUIRE(settle_on_constraints(system, *mode, 0.0, p, beside));
  CHECK((beside - on(beside[1], beside[3])).lpNorm<Eigen::Infinity>() < 1e-15);
  CHECK((beside - exact).lpNorm<Eigen::Infinity>() < 3e-5);
  Vector far = exact + vector({0.5, 0.0, 0.0, 0.0});
  CHECK_FALSE(settle_on_constraints(system, *mode, 0.0, p, far));
  // A motion begins with the move.
  Propagator propagator(system, p);
  Transition moved, from_there;
  const Vector off = exact + vector({2e-6, 0.0, 0.0, 0.0});
  carry(propagator, 0.0, 1.0, off, {.held_mode = mode}, moved);
  REQUIRE(moved.termination == Termination::time);
  CHECK(moved.lost == 2);
  Vector there = off;
  REQUIRE(settle_on_constraints(system, *mode, 0.0, p, there));
  carry(propagator, 0.0, 1.0, there, {}, from_there);
  CHECK((moved.x1 - from_there.x1).lpNorm<Eigen::Infinity>() < 1e-14);
  carry(propagator, 0.0, 1.0, Vector(exact + vector({0.01, 0.0, 0.0, 0.0})), {}, moved);  // beyond the stop, no mode named
  CHECK(moved.termination == Termination::inadmissible_start);
}

TEST_CASE("multipliers include events that follow at once: friction that reverses releases a mass from its stop") {
  // A driven block drags a light one to a stop, and away from it when the direction of friction changes.
  SystemWriter writer;
  writer.system.name = "drag";
  writer.forcing("w").parameter("w", "1").parameter("mu", "0.5");
  writer.mechanics({"x", "y"}, {"v", "u_y"},
                   {{{"1", "0"}, {"0", "1"}},
                    {{"0.3", "0"}, {"0", "0.2"}},
                    {{"0.6", "0"}, {"0", "1.7"}},
                    {"0", "4*cos(w*t) + 0.4*sin(2*w*t)"}});
  writer.stop("wall", "0.1 - x", "newton", {"0"}).friction("between", "u_y - v", "1", "mu");
  const HybridSystem system = equations::make_system(writer.system).system;
  const double T = 2.0 * std::numbers::pi;
  for (const double mu : {0.5, 1.0}) {
    INFO("mu " << mu);
    const Vector p = vector({1.0, mu});
    const PeriodicOrbit orbit = shoot(system, p, settle(system, p, vector({0.0, 0.0, 0.0, 0.0}), {.periods = 200}).state, 1);
    REQUIRE(orbit.converged());
    const auto followed = [](const EventRecord& event) { return event.is_followed; };
    const auto follows = [](const EventRecord& event) { return event.follows; };
    CHECK(std::count_if(orbit.events.begin(), orbit.events.end(), followed) == 1);
    CHECK(std::count_if(orbit.events.begin(), orbit.events.end(), follows) == 1);
    // At t = 1 the light block is off the stop, and may be displaced in either direction.
    const Vector off = simulate(system, p, 0.0, orbit.state, {.t_end = 1.0}).x;
    constexpr double h = 1e-4;
    Matrix differences(4, 4);
    for (int i = 0; i < 4; ++i) {
      const auto end = [&](double step) {
        return simulate(system, p, 1.0, off + step * Vector::Unit(4, i), {.t_end = 1.0 + T}).x;
      };
      differences.col(i) = (8.0 * (end(h) - end(-h)) - (end(2.0 * h) - end(-2.0 * h))) / (12.0 * h);
    }
    const Eigen::VectorXcd expected = differences.eigenvalues();
    for (const std::complex<double>& one : orbit.multipliers.values) CHECK((expected.array() - one).abs().minCoeff() < 1e-8);
    // The derivative in a parameter, too.
    Propagator propagator(system, p, {1});
    Transition transition;
    carry(propagator, 0.0, T, orbit.state, {.sensitivity = Sensitivity::state_and_parameters}, transition);
    const auto end = [&](double step) { return simulate(system, vector({1.0, mu + step}), 0.0, orbit.state, {.t_end = T}).x; };
    const Vector by_differences = (8.0 * (end(h) - end(-h)) - (end(2.0 * h) - end(-2.0 * h))) / (12.0 * h);
    CHECK((transition.Psi.col(0) - by_differences).cwiseAbs().maxCoeff() < 1e-8);
  }
}
