// SPDX-License-Identifier: GPL-3.0-or-later
// The library is not limited to two states, one barrier or a forcing. These systems have four or three states, two barriers,
// no forcing (two of them), or a discontinuous field, and use the same library calls (one header each in support/).
#include "support/bouncing_ball.hpp"
#include "support/checks.hpp"
#include "support/driven_self_excited.hpp"
#include "support/extrapolation.hpp"
#include "support/relay_feedback.hpp"
#include "support/two_mass_oscillator.hpp"
#include "support/two_sided_orbit.hpp"
#include "support/two_sided_oscillator.hpp"
#include "support/van_der_pol_stop.hpp"

#include <graze/lib/motion/trajectory.hpp>

#include <Eigen/Eigenvalues>

#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

std::vector<HybridSystem> all_systems() {
  return {two_mass_oscillator(),
          two_sided_oscillator(true),
          two_sided_oscillator(false),
          driven_self_excited(),
          bouncing_ball(),
          van_der_pol_stop(),
          relay_feedback()};
}

}  // namespace

TEST_CASE("other systems: every derivative agrees with differences") {
  for (const HybridSystem& system : all_systems()) {
    INFO(system.name);
    REQUIRE_NOTHROW(validate(system));
    Random random(12);
    for (int i = 0; i < 10; ++i) {
      Vector p = default_parameters(system.parameters), x(static_cast<Eigen::Index>(system.states));
      for (double& value : p) value *= random(0.8, 1.2);
      for (double& value : x) value = random(-1.5, 1.5);
      const double t = random(0.0, 5.0);
      for (std::size_t mode = 0; mode < system.modes.size(); ++mode) REQUIRE_THAT(check_mode(system, mode, t, x, p), all_agree());
      for (std::size_t event = 0; event < system.events.size(); ++event)
        REQUIRE_THAT(check_event(system, event, t, x, p), all_agree());
    }
  }
}

TEST_CASE("two masses with two barriers: Phi and Psi in every parameter through impacts of both") {
  const HybridSystem system = two_mass_oscillator();
  const Vector p = parameters(system, {{"xi", 1.4}, {"r1", 0.6}, {"r2", 0.5}});
  const Vector x0 = vector({0.1, 0.8, -0.2, 0.5});
  const double T = forcing_period(system, p);
  const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 2.0 * T});
  int struck[2] = {0, 0};
  for (const EventRecord& event : run.events) {
    ++struck[event.event];
    REQUIRE(event.normal_speed > 0.1);
    REQUIRE(event.x_plus[event.event == 0 ? 0 : 2] == p[event.event == 0 ? 5 : 6]);
  }
  REQUIRE(struck[0] > 0);
  REQUIRE(struck[1] > 0);
  // Differences with steps of 1e-5 of a motion accurate to 1e-13.
  REQUIRE_THAT(check_transition(system, p, 0.0, 2.0 * T, x0, 1e-7, 1e-5), all_agree());
  Propagator propagator(system, p);
  Transition transition;
  carry(propagator, 0.0, 2.0 * T, x0, {}, transition);
  REQUIRE(std::abs(transition.log_det - transition.liouville) < 1e-12);
  // -2 b (1 + 1/mu) t + 2 ln k_r per impact.
  const double exact = -2.0 * p[0] * (1.0 + 1.0 / p[2]) * 2.0 * T + 2.0 * std::log(p[7]) * (struck[0] + struck[1]);
  REQUIRE(transition.liouville == Approx(exact).epsilon(1e-12));
}

TEST_CASE("two masses: the motion between impacts agrees with the matrix exponential") {
  // Unforced and unequal: x(t) = e^{A t} x0.
  const HybridSystem system = two_mass_oscillator();
  const Vector p = parameters(system, {{"xi", 0.0}, {"r1", 50.0}, {"r2", 50.0}});
  const Vector x0 = vector({0.3, -0.8, 0.4, 1.1});
  Matrix A(4, 4);
  system.modes[0].field_dx(0.0, x0, p, A);
  const Eigen::EigenSolver<Matrix> eigen(A);
  const double t = 7.3;
  const Eigen::MatrixXcd V = eigen.eigenvectors();
  const Matrix exponential = (V * (eigen.eigenvalues() * t).array().exp().matrix().asDiagonal() * V.inverse()).real();
  Propagator propagator(system, p);
  Transition transition;
  carry(propagator, 0.0, t, x0, {}, transition);
  REQUIRE((transition.x1 - exponential * x0).norm() < 1e-12);
  REQUIRE((transition.Phi - exponential).norm() < 1e-12);
}

TEST_CASE("symmetric barriers: a motion and its mirror image half a period later are the same motion") {
  for (const bool rigid : {true, false}) {
    const HybridSystem system = two_sided_oscillator(rigid);
    const Vector p = parameters(system, {{"xi", 1.7}, {"r", 0.8}, {"eta", 0.9}});
    const double T = forcing_period(system, p);
    const Vector x0 = vector({0.2, 1.1});
    const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 1.5 * T});
    const Trajectory mirror = simulate(system, p, T / 2, -x0, {.t_end = 2.0 * T});
    INFO(system.name);
    REQUIRE(run.events.size() >= 3);
    REQUIRE(run.events.size() == mirror.events.size());
    REQUIRE((run.x + mirror.x).norm() < 1e-11);
    bool lower = false, upper = false;
    for (std::size_t i = 0; i < run.events.size(); ++i) {
      REQUIRE(run.events[i].t + T / 2 == Approx(mirror.events[i].t).margin(1e-11));
      REQUIRE(run.events[i].kind == mirror.events[i].kind);
      REQUIRE(run.events[i].event != mirror.events[i].event);
      lower = lower || run.events[i].x_minus[0] < 0.0;
      upper = upper || run.events[i].x_minus[0] > 0.0;
    }
    REQUIRE(lower);
    REQUIRE(upper);
    REQUIRE_THAT(check_transition(system, p, 0.0, 1.5 * T, x0, 1e-7, 1e-5), all_agree());
    // Its soft contacts are listed as contacts, on either side.
    for (const Contact& contact : contacts(run.events)) {
      if (!contact.complete) continue;
      REQUIRE(contact.entry_speed > 0.0);
      REQUIRE(contact.restitution > 0.5);
      REQUIRE(contact.restitution < 1.2);  // above 1 where the forcing does work during the contact
    }
  }
}

TEST_CASE("symmetric rigid barriers: the closed form of the symmetric orbit and its multipliers up to the pitchfork") {
  const HybridSystem system = two_sided_oscillator(true);
  for (const double eta : {1.3, 1.5, 1.6, 1.8}) {
    const Vector p = parameters(system, {{"xi", 2.0}, {"eta", eta}});
    const auto orbit = two_sided_orbit(p[0], p[1], p[2], p[3], p[4]);
    REQUIRE(orbit.has_value());
    const Vector x0 = vector({static_cast<double>(orbit->x), static_cast<double>(orbit->x_dot)});
    Propagator propagator(system, p);
    Transition transition;
    carry(propagator, 0.0, forcing_period(system, p), x0, {.keep_events = true}, transition);
    INFO("eta " << eta);
    REQUIRE(transition.events.size() == 2);
    REQUIRE(transition.events[0].normal_speed == Approx(static_cast<double>(orbit->v)).epsilon(1e-12));
    REQUIRE((transition.x1 - x0).norm() < 1e-12);
    // The matrix over a period is the square of the one over half of it: mu = nu^2.
    const double trace = static_cast<double>(orbit->trace), det = static_cast<double>(orbit->det);
    REQUIRE(transition.Phi.trace() == Approx(trace * trace - 2.0 * det).epsilon(1e-11));
    REQUIRE(transition.Phi.determinant() == Approx(det * det).epsilon(1e-11));
  }
  REQUIRE(static_cast<double>(two_sided_pitchfork(0.05L, 2, 1, 0.8L, 1.4L, 1.6L)) == Approx(1.5299072088081).epsilon(1e-12));
}

TEST_CASE("a driven self-excited oscillator: the driver does not feel the driven mass") {
  const HybridSystem system = driven_self_excited();
  const Vector p = parameters(system, {{"epsilon", 0.3}, {"mu", 0.1}});
  const double T = forcing_period(system, p);
  const Vector x0 = vector({0.0, 1.0, 0.5, -0.2});
  Propagator propagator(system, p);
  Transition transition;
  carry(propagator, 0.0, 2.0 * T, x0, {.keep_events = true}, transition);
  REQUIRE(transition.events.size() >= 1);
  REQUIRE(transition.Phi.topRightCorner(2, 2).norm() == 0.0);
  REQUIRE(transition.Phi.bottomLeftCorner(2, 2).norm() > 0.1);
  // Impact of x: y and y' are unchanged, but the change of the impact time shifts their perturbation.
  REQUIRE(transition.events[0].x_minus.tail(2) == transition.events[0].x_plus.tail(2));
  REQUIRE_THAT(check_transition(system, p, 0.0, 2.0 * T, x0, 1e-7, 1e-5), all_agree());
}

TEST_CASE("a driven self-excited oscillator at rest has the closed-form multipliers that cross the unit circle at mu = 0") {
  const HybridSystem system = driven_self_excited();
  for (const double mu : {-0.2, 0.0, 0.1}) {
    const Vector p = parameters(system, {{"epsilon", 0.0}, {"mu", mu}});
    const double T = forcing_period(system, p), omega = p[6];
    Propagator propagator(system, p);
    Transition transition;
    carry(propagator, 0.0, T, vector({0.3, 1.0, 0.0, 0.0}), {}, transition);
    const Matrix block = transition.Phi.bottomRightCorner(2, 2);
    const double modulus = std::exp(mu * T), angle = std::sqrt(omega * omega - mu * mu / 4.0) * T;
    REQUIRE(block.determinant() == Approx(modulus).epsilon(1e-12));
    REQUIRE(block.trace() == Approx(2.0 * std::sqrt(modulus) * std::cos(angle)).margin(1e-12));
  }
}

TEST_CASE("an autonomous self-excited oscillator with a stop settles on a cycle and Phi maps its field direction to itself") {
  const HybridSystem system = van_der_pol_stop();
  const Vector p = default_parameters(system.parameters);
  const Trajectory run = simulate(system, p, 0.0, vector({0.1, 0.0}), {.t_end = 400.0});
  REQUIRE(run.termination == Termination::time);
  REQUIRE(run.events.size() > 20);
  const EventRecord &last = run.events.back(), &before = run.events[run.events.size() - 2];
  REQUIRE(last.normal_speed == Approx(before.normal_speed).epsilon(1e-9));
  const double period = last.t - before.t;
  Propagator propagator(system, p);
  Transition transition;
  const Vector x0 = vector({0.0, 1.0});
  const Trajectory on = simulate(system, p, 0.0, last.x_plus, {.t_end = 1.0});  // a point of the cycle off the barrier
  carry(propagator, 0.0, period, on.x, {}, transition);
  REQUIRE((transition.x1 - on.x).norm() < 1e-8);
  Vector direction(2);
  system.modes[0].field(0.0, on.x, p, direction);
  REQUIRE((transition.Phi * direction - direction).norm() < 1e-7 * direction.norm());
  REQUIRE_THAT(check_transition(system, p, 0.0, 1.5 * period, on.x, 1e-7, 1e-5), all_agree());
  static_cast<void>(x0);
}

TEST_CASE("a relay with three states: the limit cycle agrees with the closed form through a discontinuous field") {
  const HybridSystem system = relay_feedback();
  const Vector p = default_parameters(system.parameters);
  // Half a period h: x(0) = -(I + e^{A h})^{-1} (I - e^{A h}) e with A of three first-order lags in series, e = (1, 1, 1):
  // x1(0) = -w.
  const auto exponential = [](double h) {
    Matrix E(3, 3);  // e^{-h} [[1, h, h^2/2], [0, 1, h], [0, 0, 1]]
    E << 1.0, h, h * h / 2.0, 0.0, 1.0, h, 0.0, 0.0, 1.0;
    return Matrix(std::exp(-h) * E);
  };
  const auto start = [&](double h) {
    const Matrix E = exponential(h), I = Matrix::Identity(3, 3);
    return Vector(-(I + E).lu().solve((I - E) * Vector::Ones(3)));
  };
  double lo = 0.5, hi = 20.0;  // x1(0) falls from 0 to -1 as h grows beyond the cycle
  for (int i = 0; i < 100; ++i) {
    const double mid = 0.5 * (lo + hi);
    (start(mid)[0] > -p[2] ? lo : hi) = mid;
  }
  Vector x0 = start(lo);
  x0[0] = -p[2] - 1e-15;  // switched up a moment ago
  const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 2.2 * lo});
  REQUIRE(run.events.size() >= 2);
  REQUIRE(run.events[0].t == Approx(lo).epsilon(1e-12));
  REQUIRE(run.events[1].t == Approx(2.0 * lo).epsilon(1e-12));
  REQUIRE((run.events[1].x_plus - start(lo)).norm() < 1e-12);
  REQUIRE((run.events[0].x_plus + start(lo)).norm() < 1e-12);
  // The saltation of a switch without reset: S = I + (f+ - f-) h_x / c.
  REQUIRE_THAT(check_transition(system, p, 0.0, 2.2 * lo, x0, 1e-8), all_agree());
  Propagator propagator(system, p);
  Transition transition;
  carry(propagator, 0.0, 2.0 * lo + 0.1, x0, {.keep_factors = true, .keep_events = true}, transition);
  REQUIRE(transition.factors.size() == 5);
  REQUIRE((transition.factors[1] - Matrix::Identity(3, 3)).norm() > 0.1);
}

TEST_CASE("the derivatives of a bouncing ball in g, floor and k_r agree with differences through several bounces") {
  const HybridSystem system = bouncing_ball();
  const Vector p = parameters(system, {{"k_r", 0.8}});
  REQUIRE_THAT(check_transition(system, p, 0.0, 2.0, vector({1.0, 0.3}), 1e-8), all_agree());
  // Closed form: after one bounce at t1 = sqrt(2 H/g) the speed at t is k_r g t1 - g (t - t1).
  const Trajectory run = simulate(system, p, 0.0, vector({1.0, 0.0}), {.t_end = 0.7});
  const double t1 = std::sqrt(2.0 / 9.81);
  REQUIRE(run.events.size() == 1);
  REQUIRE(run.events[0].t == Approx(t1).epsilon(1e-15));
  REQUIRE(run.x[1] == Approx(0.8 * 9.81 * t1 - 9.81 * (0.7 - t1)).epsilon(1e-14));
}
