// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits of systems beyond the one-barrier oscillator, through the same calls: two degrees of freedom with two barriers,
// autonomous limit cycles with impacts or switches, four states with known complex multipliers.
#include <graze/floquet/attractor/settle.hpp>

#include "support/checks.hpp"
#include "support/driven_self_excited.hpp"
#include "support/relay_feedback.hpp"
#include "support/two_mass_oscillator.hpp"
#include "support/two_sided_oscillator.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

#include <numbers>
#include <unsupported/Eigen/MatrixFunctions>

using namespace graze;
using namespace graze::support;

namespace {

/// Checks that apply to any orbit. The finite differences use the general flow with an error of 1e-13 a step.
void check_proofs(const HybridSystem& system, const PeriodicOrbit& orbit) {
  CHECK(orbit.checks.residual < 1e-12);
  CHECK(orbit.checks.liouville >= 0.0);
  CHECK(orbit.checks.liouville < 1e-10);
  const FiniteDifferenceCheck differences = finite_difference_check(system, orbit);
  REQUIRE(differences.applicable);
  CHECK(differences.disagreement < std::max(1e-8, differences.error_estimate));
  CHECK(differences.error_estimate < 1e-5);
  CHECK(orbit.admissible == Admissibility::admissible);
}

PeriodicOrbit settled_orbit(const HybridSystem& system, const Vector& p, int periods = 600) {
  const Settled settled = settle(system, p, Vector::Zero(static_cast<Eigen::Index>(system.states)), {.periods = periods});
  REQUIRE(settled.suspected_period > 0);
  return shoot(system, p, settled.state, settled.suspected_period);
}

/// Approximate state and duration of the limit cycle of a run from near the origin.
struct LimitCycle {
  Vector state;
  double duration;
};
LimitCycle settled_cycle(const HybridSystem& system, const Vector& p) {
  const Trajectory run = simulate(system, p, 0.0, vector({0.1, 0.0}), {.t_end = 40.0});
  REQUIRE(run.events.size() > 2);
  return {run.x, run.events.back().t - run.events[run.events.size() - 2].t};
}

}  // namespace

TEST_CASE("the four multipliers of a two-degree-of-freedom orbit have the product given by Liouville") {
  const HybridSystem system = two_mass_oscillator();
  for (const auto& set : {std::pair{1.0, 0.9}, {2.0, 0.7}, {1.5, 1.3}}) {
    const Vector p = parameters(system, {{"xi", set.first}, {"eta", set.second}});
    INFO("xi " << set.first << " eta " << set.second);
    const PeriodicOrbit orbit = settled_orbit(system, p);
    REQUIRE(orbit.converged());
    CHECK(orbit.impacts > 0);
    REQUIRE(orbit.multipliers.values.size() == 4);
    CHECK(orbit.stable());
    check_proofs(system, orbit);
    double logs = 0.0;
    for (const auto& mu : orbit.multipliers.values) logs += std::log(std::abs(mu));
    // Friction of both masses over the duration, k_r^2 at each impact.
    const double expected = -2.0 * 0.05 * (1.0 + 1.0 / 0.8) * orbit.duration + 2.0 * orbit.impacts * std::log(0.8);
    CHECK(logs == Approx(expected).epsilon(1e-11));
  }
}

TEST_CASE("a two-degree-of-freedom orbit is the same for every number of nodes") {
  const HybridSystem system = two_mass_oscillator();
  const PeriodicOrbit orbit = settled_orbit(system, parameters(system));
  REQUIRE(orbit.converged());
  for (const int nodes : {1, 3 * orbit.period, 8 * orbit.period}) {
    const PeriodicOrbit again =
        shoot(system, orbit.parameters, Vector(orbit.state + vector({-1e-4, 1e-4, -1e-4, 1e-4})), orbit.period, {.nodes = nodes});
    REQUIRE(again.converged());
    CHECK((again.state - orbit.state).lpNorm<Eigen::Infinity>() < 1e-11);
    for (std::size_t i = 0; i < 4; ++i) CHECK(std::abs(again.multipliers.values[i] - orbit.multipliers.values[i]) < 1e-9);
    CHECK(again.signature == orbit.signature);
  }
}

TEST_CASE("with one coefficient of restitution 0 a multiplier is exactly zero and the largest one is not") {
  // Each impact on one mass removes one direction; the flights in between mix them.
  const HybridSystem system = two_mass_oscillator();
  const PeriodicOrbit orbit = settled_orbit(system, parameters(system, {{"k_r", 0.0}}));
  REQUIRE(orbit.converged());
  REQUIRE(orbit.multipliers.valid);
  CHECK(orbit.multipliers.values.back() == 0.0);
  CHECK(orbit.multipliers.values.front() != 0.0);
  CHECK(orbit.checks.liouville == -1.0);
}

TEST_CASE("multipliers of a self-excited oscillator uncoupled from an impacting one have their closed form") {
  const HybridSystem system = driven_self_excited();
  for (const double mu : {-0.4, -0.1, 0.05}) {
    const Vector p = parameters(system, {{"mu", mu}});
    // y = 0 is an orbit of the second oscillator, stable or not; the first one settles by itself.
    Propagator propagator(system, p);
    Transition transition;
    Vector x = Vector::Zero(4);
    const double T = forcing_period(system, p);
    for (int k = 0; k < 300; ++k) {
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none}, transition);
      x = transition.x1;
    }
    const PeriodicOrbit orbit = shoot(system, p, x, 1);
    REQUIRE(orbit.converged());
    INFO("mu " << mu);
    const double omega = std::sqrt(0.55 * 0.55 - 0.25 * mu * mu);
    const std::complex<double> pair = std::polar(std::exp(0.5 * mu * orbit.duration), omega * orbit.duration);
    int found = 0;
    for (const auto& value : orbit.multipliers.values)
      found += std::abs(value - pair) < 1e-10 || std::abs(value - std::conj(pair)) < 1e-10;
    CHECK(found == 2);
    CHECK(orbit.multipliers.unstable() == (mu > 0.0 ? 2 : 0));
    CHECK(orbit.multipliers.trivial == 0);
    check_proofs(system, orbit);
  }
}

TEST_CASE("an autonomous orbit is found with its duration and declares one trivial multiplier") {
  const HybridSystem system = van_der_pol_stop();
  const Vector p = parameters(system);
  for (const int nodes : {1, 2, 5}) {
    INFO(nodes << " nodes");
    const LimitCycle guess = settled_cycle(system, p);
    const PeriodicOrbit orbit = shoot(system, p, std::vector<Vector>{guess.state}, 1, {.nodes = nodes}, guess.duration);
    REQUIRE(orbit.converged());
    CHECK(orbit.impacts == 1);
    CHECK(orbit.multipliers.section == Section::autonomous);
    CHECK(orbit.multipliers.trivial == 1);
    REQUIRE(orbit.multipliers.values.size() == 2);
    CHECK(std::abs(orbit.multipliers.values[1] - 1.0) < 1e-10);
    check_proofs(system, orbit);
    // Its duration is the return time of the impact. The other multiplier is the slope of the map from one impact speed to the
    // next, from a simulation.
    const auto next = [&](double speed) {
      const Trajectory run = simulate(system, p, 0.0, vector({1.2, -0.9 * speed}), {.t_end = 50.0, .max_events = 1});
      return std::pair{run.t, run.events.front().normal_speed};
    };
    const double speed = orbit.events.front().normal_speed;
    CHECK(next(speed).first == Approx(orbit.duration).epsilon(1e-11));
    CHECK(next(speed).second == Approx(speed).epsilon(1e-11));
    const double h = 1e-3, coarse = (next(speed + h).second - next(speed - h).second) / (2.0 * h),
                 fine = (next(speed + h / 2).second - next(speed - h / 2).second) / h;
    CHECK(orbit.multipliers.values[0].real() == Approx((4.0 * fine - coarse) / 3.0).epsilon(1e-8));
  }
}

TEST_CASE("an autonomous orbit does not depend on the start along it") {
  const HybridSystem system = van_der_pol_stop();
  const Vector p = parameters(system);
  const LimitCycle guess = settled_cycle(system, p);
  const PeriodicOrbit orbit = shoot(system, p, std::vector<Vector>{guess.state}, 1, {}, guess.duration);
  REQUIRE(orbit.converged());
  for (const double fraction : {0.13, 0.37, 0.55, 0.88}) {
    const Trajectory run = simulate(system, p, 0.0, orbit.state, {.t_end = fraction * orbit.duration});
    const PeriodicOrbit again =
        shoot(system, p, std::vector<Vector>{run.x + Vector(vector({-0.01, 0.01}))}, 1, {}, 0.98 * orbit.duration);
    INFO("from " << fraction << " of the orbit");
    REQUIRE(again.converged());
    CHECK(again.duration == Approx(orbit.duration).epsilon(1e-12));
    CHECK(again.multipliers.values[0].real() == Approx(orbit.multipliers.values[0].real()).epsilon(1e-10));
  }
}

TEST_CASE("the limit cycle of a relay agrees with its closed form in duration, state and multipliers") {
  const HybridSystem system = relay_feedback();
  for (const double w : {0.05, 0.2}) {
    for (const double a : {1.0, 2.5}) {
      const Vector p = parameters(system, {{"w", w}, {"a", a}});
      INFO("w " << w << " a " << a);
      // Half a period h in mode "up" from x to -x: (I + e^{Ah}) x = -A^{-1} (e^{Ah} - I) B, and x1(h) = w determines h.
      Matrix A(3, 3);
      A << -a, a, 0.0, 0.0, -a, a, 0.0, 0.0, -a;
      const Vector B = vector({0.0, 0.0, a});
      const Matrix I = Matrix::Identity(3, 3);
      const auto start = [&](double h) {
        const Matrix e = (A * h).exp();
        return Vector(-(I + e).lu().solve(A.lu().solve((e - I) * B)));
      };
      double low = 0.05 / a, high = 6.0 / a;  // x1(h) + w falls from w to below 0
      REQUIRE(start(low)[0] + w > 0.0);
      REQUIRE(start(high)[0] + w < 0.0);
      for (int i = 0; i < 100; ++i) (start(0.5 * (low + high))[0] + w > 0.0 ? low : high) = 0.5 * (low + high);
      const double h = 0.5 * (low + high);
      const Vector x = start(h);
      // One switch: S = I + (f+ - f-) C / (C f-) with C = (1, 0, 0) and f-+ = A(-x) +- B.
      const Vector f_minus = A * -x + B, f_plus = A * -x - B;
      Matrix S = I;
      S.col(0) += (f_plus - f_minus) / f_minus[0];
      const Matrix half = S * (A * h).exp();
      std::vector<std::complex<double>> expected;
      const Eigen::VectorXcd exact = Matrix(half * half).eigenvalues();
      expected.assign(exact.begin(), exact.end());

      const Vector beside = (A * (0.3 * h)).exp() * x + A.lu().solve(((A * (0.3 * h)).exp() - I) * B);
      const PeriodicOrbit orbit = shoot(system, p, std::vector<Vector>{beside + 0.01 * B}, 1, {}, 2.1 * h);
      REQUIRE(orbit.converged());
      CHECK(orbit.duration == Approx(2.0 * h).epsilon(1e-11));
      REQUIRE(orbit.events.size() == 2);
      const EventRecord& down = orbit.events.front();
      CHECK((down.x_minus + x).lpNorm<Eigen::Infinity>() < 1e-11);
      REQUIRE(orbit.multipliers.values.size() == 3);
      for (const auto& value : orbit.multipliers.values) {
        const auto nearest = std::min_element(expected.begin(), expected.end(),
                                              [&](auto& p1, auto& p2) { return std::abs(p1 - value) < std::abs(p2 - value); });
        CHECK(std::abs(*nearest - value) < 1e-10);
        expected.erase(nearest);
      }
      CHECK(orbit.multipliers.trivial == 1);
      CHECK(std::abs(orbit.multipliers.values.back() - 1.0) < 1e-10);
      check_proofs(system, orbit);
    }
  }
}

TEST_CASE("symmetric barriers give symmetric orbits for rigid and elastic stops") {
  for (const bool rigid : {true, false}) {
    const HybridSystem system = two_sided_oscillator(rigid);
    const Vector p = parameters(system, {{"eta", 1.1}});
    const PeriodicOrbit orbit = settled_orbit(system, p);
    INFO((rigid ? "rigid" : "elastic"));
    REQUIRE(orbit.converged());
    check_proofs(system, orbit);
    CHECK(orbit.impacts == 2 * orbit.period);
    const Trajectory half = simulate(system, p, 0.0, orbit.state, {.t_end = 0.5 * forcing_period(system, p)});
    // The shifted and reflected orbit is an orbit too; here it is the same.
    const PeriodicOrbit mirrored = shoot(system, p, Vector(-half.x), orbit.period);
    REQUIRE(mirrored.converged());
    CHECK(same_orbit(orbit, mirrored));
  }
}
