// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's method on the shooting equations: its history, its terminations, its response to misuse, and the Jacobian.
#include <graze/floquet/orbit/shooting.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"
#include "support/damped_hertz.hpp"
#include "support/newton_oscillator.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

Vector damped(double eta) { return parameters(damped_hertz(), {{"eta", eta}, {"b_H", 0.1}}); }
const Vector near_1_1 = vector({2.0492, 1.4284});  // at eta 0.925, to 4 digits

/// The message for a misuse; "nothing was thrown" if there was none.
template <class Call> std::string refused(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace

TEST_CASE("Newton's residual history falls quadratically to rounding") {
  // Starts 1 to 5 per cent away, single and multiple shooting, soft and hard contact.
  struct Start {
    const HybridSystem& system;
    Vector p, x;
    int period;
  };
  const std::vector<Start> starts{
      {damped_hertz(), damped(0.925), vector({2.03, 1.40}), 1},
      {damped_hertz(), damped(0.91), vector({2.22, 1.87}), 2},
      {newton_oscillator(), parameters(newton_oscillator(), {{"eta", 0.9}}), vector({1.88, 2.62}), 2},
      {newton_oscillator(), parameters(newton_oscillator(), {{"eta", 0.744}}), vector({1.905, -0.705}), 4}};
  for (const Start& start : starts) {
    for (const int nodes : {1, start.period}) {
      const PeriodicOrbit orbit = shoot(start.system, start.p, start.x, start.period, {.nodes = nodes});
      REQUIRE(orbit.converged());
      const std::vector<double>& history = orbit.newton.residual_history;
      INFO("period " << start.period << ", " << nodes << " nodes: " << Catch::Detail::stringify(history));
      CHECK(orbit.newton.iterations() + 1 == static_cast<int>(history.size()));
      CHECK(orbit.newton.residual() == history.back());
      CHECK(history.back() < 1e-13);
      int quadratic = 0;
      for (std::size_t k = 0; k + 1 < history.size(); ++k) {
        CHECK(history[k + 1] <= history[k]);
        // The constant is the curvature of the map over its slope: some 100, or 1000 for a hard impact of speed 0.3. Rounding
        // is the floor.
        if (history[k] > 1e-4) continue;
        CHECK(history[k + 1] < 3000.0 * history[k] * history[k] + 1e-13);
        quadratic += history[k] > 1e-9 ? 1 : 0;
      }
      CHECK(quadratic >= 1);
    }
  }
}

TEST_CASE("an orbit that does not exist is a status with its history and not an exception") {
  // The damped Hertz oscillator has no orbit of period 3 at eta 0.711 (60 x 60 starts find none).
  const PeriodicOrbit orbit = shoot(damped_hertz(), damped(0.711), vector({1.0, 0.5}), 3);
  CHECK_FALSE(orbit.converged());
  CHECK((orbit.newton.status == NewtonStatus::stalled || orbit.newton.status == NewtonStatus::iteration_limit));
  CHECK(orbit.newton.residual_history.size() > 1);
  CHECK(orbit.newton.residual() > 1e-6);
  CHECK_FALSE(newton_status_text(orbit.newton.status).empty());
  CHECK(orbit.state.size() == 2);
}

TEST_CASE("reaching the largest number of Newton iterations is a status") {
  const PeriodicOrbit orbit = shoot(damped_hertz(), damped(0.925), vector({1.9, 1.2}), 1, {.max_iterations = 2});
  CHECK(orbit.newton.status == NewtonStatus::iteration_limit);
  CHECK(orbit.newton.iterations() == 2);
  CHECK(newton_status_text(orbit.newton.status) == "the largest number of iterations was reached");
}

TEST_CASE("a failed evaluation is a status") {
  FlowOptions options;
  options.max_steps = 1;
  options.kind = FlowKind::general;
  ShootingOptions shooting;
  shooting.flow = options;
  const PeriodicOrbit orbit = shoot(damped_hertz(), damped(0.925), near_1_1, 1, shooting);
  CHECK(orbit.newton.status == NewtonStatus::evaluation_failed);
  CHECK_FALSE(orbit.converged());
  CHECK_FALSE(orbit.multipliers.valid);
}

TEST_CASE("a Newton report that was never run is not converged") {
  const NewtonReport report;
  CHECK(report.status == NewtonStatus::not_run);
  CHECK_FALSE(report.converged());
  CHECK(report.iterations() == 0);
  CHECK(report.residual() == -1.0);
  CHECK(PeriodicOrbit().stable() == false);
}

TEST_CASE("misuse of shoot is refused in a sentence") {
  const Vector p = damped(0.925);
  CHECK(refused([&] { shoot(damped_hertz(), p, near_1_1, 0); }) == "period n is 0; allowed is a whole number from 1");
  CHECK(refused([&] { shoot(damped_hertz(), p, near_1_1, -2); }) == "period n is -2; allowed is a whole number from 1");
  CHECK(refused([&] { shoot(damped_hertz(), p, near_1_1, 3, {.nodes = 2}); }) ==
        "2 shooting nodes were asked for; allowed is a multiple or a divisor of the period 3");
  CHECK(refused([&] { shoot(damped_hertz(), p, near_1_1, 3, {.nodes = -3}); }) ==
        "-3 shooting nodes were asked for; allowed is a multiple or a divisor of the period 3");
  CHECK(refused([&] { shoot(damped_hertz(), p, std::vector<Vector>{}, 1); }) == "shooting needs a state to start from");
  CHECK(refused([&] {
          shoot(damped_hertz(), p, vector({1.0, 2.0, 3.0}), 1);
        }) == "the state has 3 entries; system linear-hertz has 2");
  CHECK(refused([&] {
          shoot(damped_hertz(), p, vector({1.0, std::nan("")}), 1);
        }) == "the state holds a value that is not a finite number");
  CHECK(refused([&] {
          shoot(newton_oscillator(), parameters(newton_oscillator()), vector({2.5, 0.0}), 1);
        }) == "the state (2.5, 0) lies inside the barrier; start on the free side of it");
  CHECK(refused([&] {
          shoot(newton_oscillator(), parameters(newton_oscillator(), {{"k_r", 1.2}}), near_1_1, 1);
        }) == "parameter k_r is 1.2; allowed is [0, 1]");
  CHECK(refused([&] {
          shoot(damped_hertz(), vector({0.05, 0.0}), near_1_1, 1);
        }) == "2 parameter values were given; this model has 7");
}

TEST_CASE("misuse of shoot with autonomous systems is refused in a sentence") {
  const HybridSystem system = van_der_pol_stop();
  const Vector p = parameters(system), x = vector({0.0, 2.0});
  CHECK(refused([&] { shoot(system, p, std::vector<Vector>{x}, 1); }) ==
        "the duration guess is 0; an autonomous orbit needs one > 0");
  CHECK(refused([&] { shoot(system, p, std::vector<Vector>{x}, 1, {}, -3.0); }) ==
        "the duration guess is -3; an autonomous orbit needs one > 0");
  CHECK(refused([&] { shoot(system, p, std::vector<Vector>{x}, 2, {}, 6.0); }) ==
        "an autonomous orbit has period 1: its duration is an unknown");
}

TEST_CASE("several states are a guess for multiple shooting, node by node") {
  // The 2/2 orbit of Newton's law at eta 0.744 is unstable (multiplier -1.1): rough states at both nodes lead to it.
  const Vector p = parameters(newton_oscillator(), {{"eta", 0.744}});
  const PeriodicOrbit known = shoot(newton_oscillator(), p, vector({1.70, 0.85}), 2);
  REQUIRE(known.converged());
  REQUIRE(known.period == 2);
  const std::vector<Vector> rough{known.states[0] + Vector(vector({-0.01, 0.02})),
                                  known.states[1] + Vector(vector({-0.02, -0.01}))};
  const PeriodicOrbit orbit = shoot(newton_oscillator(), p, rough, 2);
  REQUIRE(orbit.converged());
  CHECK(same_orbit(orbit, known));
  // The history begins with the mismatch of the rough states, not with that of a run from the first of them.
  CHECK(orbit.newton.residual_history.front() < 0.1);
}

TEST_CASE("an orbit of period n that closes after a divisor of n is returned with its least period") {
  for (const int n : {2, 3, 4, 6, 12}) {
    INFO("requested period " << n);
    const PeriodicOrbit orbit = shoot(damped_hertz(), damped(0.925), near_1_1, n);
    REQUIRE(orbit.converged());
    CHECK(orbit.period == 1);
    CHECK(orbit.nodes.size() == 1);
    CHECK(std::abs(orbit.multipliers.values[0].real() + 0.94165004595) < 1e-10);
  }
  // A 1/2 orbit with requested period 4, with 2, 4 and 8 nodes.
  for (const int nodes : {1, 2, 4, 8}) {
    INFO(nodes << " nodes");
    const PeriodicOrbit orbit = shoot(damped_hertz(), damped(0.91), vector({2.2377, 1.8827}), 4, {.nodes = nodes});
    REQUIRE(orbit.converged());
    CHECK(orbit.period == 2);
    CHECK(orbit.impacts == 1);
  }
}

TEST_CASE("on request an orbit keeps the requested period and its multipliers are raised to that power") {
  const PeriodicOrbit once = shoot(damped_hertz(), damped(0.925), near_1_1, 1);
  const PeriodicOrbit thrice = shoot(damped_hertz(), damped(0.925), near_1_1, 3, {.reduce_period = false});
  REQUIRE(thrice.converged());
  CHECK(thrice.period == 3);
  CHECK(thrice.impacts == 3);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(std::abs(thrice.multipliers.values[i] - std::pow(once.multipliers.values[i], 3)) < 1e-12);
    CHECK(thrice.multipliers.exponents[i] == Approx(once.multipliers.exponents[i]).margin(1e-12));
  }
}

TEST_CASE("a doubled orbit near its birth is not taken for its parent") {
  // Its two states are 17.7 sqrt(distance in eta) apart: 0.0056 at the last of these, where the parent almost closes the gap.
  for (const double below : {1e-5, 1e-6, 1e-7}) {
    const double eta = 0.919542643087348 - below;
    const PeriodicOrbit parent = shoot(damped_hertz(), damped(eta), vector({2.05188, 1.39547}), 1);
    REQUIRE(parent.converged());
    // Along the eigenvector of -1: M = [[-0.897, -0.086], [-0.590, -0.505]], M v = -v.
    const Vector v = vector({0.6426, 0.7662});
    const PeriodicOrbit doubled = shoot(damped_hertz(), damped(eta), Vector(parent.state + 9.2 * std::sqrt(below) * v), 2);
    INFO("below by " << below);
    REQUIRE(doubled.converged());
    REQUIRE(doubled.period == 2);
    CHECK_FALSE(same_orbit(parent, doubled));
    CHECK((doubled.states[0] - doubled.states[1]).norm() == Approx(17.7 * std::sqrt(below)).epsilon(0.02));
    // With requested period 4 the result is again the doubled orbit, not the parent.
    const PeriodicOrbit again = shoot(damped_hertz(), damped(eta), doubled.state, 4);
    CHECK(again.period == 2);
    CHECK(same_orbit(again, doubled));
  }
}

TEST_CASE("same_orbit recognises an orbit from another of its periods and distinguishes different ones") {
  const Vector p = parameters(newton_oscillator(), {{"eta", 0.744}});
  const PeriodicOrbit orbit = shoot(newton_oscillator(), p, vector({1.904, -0.703}), 4);
  REQUIRE(orbit.period == 4);
  for (const int nodes : {1, 2, 4, 8}) {
    for (const Vector& state : orbit.states) {
      const PeriodicOrbit shifted = shoot(newton_oscillator(), p, state, 4, {.nodes = nodes});
      REQUIRE(shifted.converged());
      CHECK(same_orbit(orbit, shifted));
      CHECK(same_orbit(shifted, orbit));
    }
  }
  const PeriodicOrbit other = shoot(newton_oscillator(), p, vector({1.488, 1.730}), 3),
                      another = shoot(newton_oscillator(), p, vector({1.604, 1.094}), 3);
  REQUIRE(other.converged());
  REQUIRE(another.converged());
  CHECK(other.period == another.period);
  CHECK_FALSE(same_orbit(other, another));
  CHECK_FALSE(same_orbit(orbit, other));
}

TEST_CASE("events of an orbit are listed from phase 0 for any nodes") {
  const Vector p = parameters(newton_oscillator(), {{"eta", 0.744}});
  const PeriodicOrbit orbit = shoot(newton_oscillator(), p, vector({1.904, -0.703}), 4);
  REQUIRE(orbit.converged());
  for (const int nodes : {1, 2, 8, 20}) {
    const PeriodicOrbit again = shoot(newton_oscillator(), p, orbit.state, 4, {.nodes = nodes});
    REQUIRE(again.events.size() == orbit.events.size());
    CHECK(again.signature == orbit.signature);
    for (std::size_t i = 0; i < orbit.events.size(); ++i) {
      CHECK(again.events[i].t == Approx(orbit.events[i].t).epsilon(1e-12));
      CHECK(again.events[i].t < again.duration);
      if (i > 0) CHECK(again.events[i].t > again.events[i - 1].t);
    }
  }
}

TEST_CASE("the Jacobian of the shooting equations agrees with central differences") {
  // Each parameter in turn is the last column. Its change affects the times of the stretches (eta) or their fields and resets.
  struct Point {
    const HybridSystem& system;
    Vector p, x;
    int period;
  };
  const std::vector<Point> points{
      {damped_hertz(), damped(0.91), vector({2.2, 1.9}), 2},
      {newton_oscillator(), parameters(newton_oscillator(), {{"eta", 0.9}, {"k_r", 0.8}}), vector({1.7, 2.4}), 2}};
  for (const Point& point : points) {
    for (const int nodes : {1, 2, 6}) {
      for (std::size_t active = 0; active < point.system.parameters.size(); ++active) {
        if (point.system.parameters[active].name == "k_r" || point.system.parameters[active].name == "b_H")
          continue;  // at an end of its range
        ShootingEquations equations(point.system, point.p, point.period, nodes, {active});
        const auto residual_at = [&](const Vector& z) {
          Vector q = point.p, r;
          q[static_cast<Eigen::Index>(active)] = z[z.size() - 1];
          equations.set_parameters(q);
          REQUIRE(equations.evaluate(z.head(z.size() - 1), {.sensitivity = Sensitivity::state_and_parameters}));
          equations.residual(z.head(z.size() - 1), r);
          return r;
        };
        Vector z(equations.unknowns() + 1);
        Transition transition;
        Vector x = point.x;
        for (int j = 0; j < nodes; ++j) {
          z.segment(2 * j, 2) = x;
          const double t = equations.node_time(z, j);
          carry(equations.propagator(), t, t + equations.duration(z) / nodes, x, {}, transition);
          x = transition.x1;
        }
        z[z.size() - 1] = point.p[static_cast<Eigen::Index>(active)];
        residual_at(z);
        Matrix jacobian;
        equations.jacobian(jacobian);
        const JacobianCheck check = check_jacobian(residual_at, z, jacobian, 1e-5);
        INFO(point.system.name << ", " << nodes << " nodes, " << point.system.parameters[active].name << ": " << check.message);
        // Rounding: 1e-15 over the step.
        CHECK(check.agrees(2e-9));
      }
    }
  }
}
