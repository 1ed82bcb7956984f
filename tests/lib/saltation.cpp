// SPDX-License-Identifier: GPL-3.0-or-later
// Saltation matrices: the formula by hand, differences across one event in the state and in every parameter, grazing,
// continuity.
#include "support/checks.hpp"
#include "support/rigid_stop.hpp"
#include "support/two_mass_oscillator.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/system/saltation.hpp>

using namespace graze;
using namespace graze::support;

namespace {

/// The saltation matrix of event `index` at (t, x), with fields from the system's modes.
SaltationMatrix saltation_at(const HybridSystem& system, std::size_t index, double t, const Vector& x, const Vector& p) {
  const Event& event = system.events[index];
  Vector x_plus = x, f_minus(x.size()), f_plus(x.size());
  if (event.reset.map) event.reset.map(t, x, p, x_plus);
  system.modes[event.from].field(t, x, p, f_minus);
  system.modes[event.to].field(t, x_plus, p, f_plus);
  return saltation(event, {t, x, x_plus, f_minus, f_plus}, p, all_parameters(system));
}

/// A run that starts a little before an event and ends a little after.
struct AcrossEvent {
  Vector x0;
  double t0 = 0.0, t1 = 0.0;
};

AcrossEvent around_impact(const HybridSystem& system, const Vector& p, double t, double speed) {
  // Back in time by dt along the field. Euler's rule suffices, because the start need not lie on an exact orbit.
  const Vector x = vector({p[oscillator_parameter::r], speed});
  Vector f(2);
  system.modes[0].field(t, x, p, f);
  const double dt = std::min(0.1, 0.3 * speed / std::abs(f[1]));
  Vector x0 = x - dt * f;
  x0[0] -= 0.5 * dt * dt * f[1];
  return {x0, t - dt, t + dt};
}

}  // namespace

TEST_CASE("the saltation matrix of an impact agrees with the formula by hand") {
  // S = [[-k_r, 0], [(a+ + k_r a-)/v-, -k_r]]; a is the acceleration of the free mass before and after.
  for (const OscillatorKind& kind : oscillator_kinds()) {
    const HybridSystem system = make_oscillator(kind, contact_law("newton"));
    Random random(3);
    for (int i = 0; i < 50; ++i) {
      Vector p = parameters(system, {{"k_r", random(0.0, 1.0)}, {"r", random(-1.0, 2.0)}, {"b", random(0.0, 1.0)}});
      const double t = random(0.0, 9.0), v = random(1e-6, 3.0), k_r = p[oscillator_parameter::law];
      const auto acceleration = [&](double speed) {
        Vector f(2);
        system.modes[0].field(t, vector({p[oscillator_parameter::r], speed}), p, f);
        return f[1];
      };
      const SaltationMatrix result = saltation_at(system, 0, t, vector({p[oscillator_parameter::r], v}), p);
      Matrix expected(2, 2);
      expected << -k_r, 0.0, (acceleration(-k_r * v) + k_r * acceleration(v)) / v, -k_r;
      REQUIRE(result.regular);
      REQUIRE(result.transversality == v);
      REQUIRE((result.S - expected).norm() < 1e-14 * (1.0 + expected.norm()));
      REQUIRE(std::abs(result.S.determinant() - k_r * k_r) < 1e-14 * (1.0 + expected.norm()));
    }
  }
}

TEST_CASE("the derivative of an impact in r and in k_r agrees with the formula by hand") {
  // The impact is delayed by dt = -dh/c: x+ - k_r v- stays on the moved barrier. D_r x+ = (1 + k_r, -(a+ + k_r a-)/v-), D_k x+
  // = (0, -v-).
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"k_r", 0.7}, {"r", 0.9}});
  const double t = 1.3, v = 0.8, k_r = 0.7;
  const SaltationMatrix result = saltation_at(system, 0, t, vector({0.9, v}), p);
  const double a_minus = std::cos(0.95 * t) - 0.1 * v - 0.9, a_plus = std::cos(0.95 * t) + 0.1 * k_r * v - 0.9;
  Matrix expected = Matrix::Zero(2, 6);
  expected.col(oscillator_parameter::r) << 1.0 + k_r, -(a_plus + k_r * a_minus) / v;
  expected.col(oscillator_parameter::law) << 0.0, -v;
  REQUIRE((result.Sp - expected).norm() < 1e-14);
}

TEST_CASE("across an impact the map agrees with differences in the state and in every parameter, eta and xi included") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    const HybridSystem system = make_oscillator(kind, contact_law("newton"));
    for (const double speed : {1.5, 0.3, 0.05}) {
      for (const double t : {0.4, 2.9, 11.0}) {
        const Vector p = parameters(system, {{"k_r", 0.7}, {"r", 0.6}, {"eta", 0.8}, {"xi", 1.2}});
        const AcrossEvent run = around_impact(system, p, t, speed);
        // At small speed the return map curves like 1/speed^2. The steps, and with them their own error, are well below the
        // speed.
        const double step = 2e-3 * speed * speed;
        INFO("speed " << speed << ", t " << t);
        REQUIRE_THAT(check_transition(system, p, run.t0, run.t1, run.x0, 2e-8, std::min(step, 2e-4)), all_agree());
      }
    }
  }
}

TEST_CASE("across entry and exit of every soft contact the map is continuous: S is exactly the identity") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      if (law.hard) continue;
      const HybridSystem system = make_oscillator(kind, law);
      const Vector p = default_parameters(system.parameters);
      for (std::size_t event = 0; event < system.events.size(); ++event) {
        for (const double speed : {2.0, 1e-9, 0.0}) {  // at grazing too
          const SaltationMatrix result = saltation_at(system, event, 0.7, vector({p[oscillator_parameter::r], speed}), p);
          REQUIRE(result.regular);
          REQUIRE(result.S == Matrix::Identity(2, 2));
          REQUIRE(result.Sp == Matrix::Zero(2, p.size()));
        }
      }
    }
  }
}

TEST_CASE("the general formula gives the identity at a continuous guard as well") {
  // f+ = f- and g = x make the correction vanish. An event that is declared continuous differs only by rounding.
  HybridSystem system = make_oscillator("linear", "hertz");
  for (Event& event : system.events) event.continuous = false;
  const Vector p = default_parameters(system.parameters);
  for (std::size_t event = 0; event < 2; ++event) {
    const SaltationMatrix result = saltation_at(system, event, 0.7, vector({2.0, event == 0 ? 0.4 : -0.4}), p);
    REQUIRE(result.regular);
    REQUIRE((result.S - Matrix::Identity(2, 2)).norm() == 0.0);
    REQUIRE(result.Sp.norm() == 0.0);
  }
}

TEST_CASE("at grazing the saltation matrix of an impact is reported not to exist") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = default_parameters(system.parameters);
  for (const double speed : {0.0, 1e-14, -1e-14}) {
    const SaltationMatrix result = saltation_at(system, 0, 0.7, vector({2.0, speed}), p);
    REQUIRE_FALSE(result.regular);
    REQUIRE(result.transversality == speed);
    for (Eigen::Index i = 0; i < 2; ++i)
      for (Eigen::Index j = 0; j < 2; ++j) REQUIRE(std::isnan(result.S(i, j)));
    REQUIRE(result.Sp.size() == 2 * p.size());
    REQUIRE(result.Sp.hasNaN());
  }
  // Towards grazing S grows as 1/speed and is given as long as it has correct digits.
  const double slow = saltation_at(system, 0, 0.7, vector({2.0, 1e-8}), p).S(1, 0);
  const double slower = saltation_at(system, 0, 0.7, vector({2.0, 1e-10}), p).S(1, 0);
  REQUIRE(slower / slow == Approx(100.0).epsilon(1e-6));
}

TEST_CASE("a transition that meets an impact of zero speed ends as grazing") {
  // Two masses without sticking: the first is at rest on its barrier and pressed against it.
  const HybridSystem system = two_mass_oscillator();
  Propagator propagator(system, parameters(system, {{"xi", 5.0}}));
  Transition transition;
  carry(propagator, 0.0, 1.0, vector({1.0, 0.0, 0.0, 0.0}), {}, transition);
  REQUIRE(transition.termination == Termination::grazing);
  REQUIRE(transition.event_sequence == std::vector<std::size_t>{0});
  // Without the sensitivity the run ends by number of events, because time does not advance.
  carry(propagator, 0.0, 1.0, vector({1.0, 0.0, 0.0, 0.0}), {.sensitivity = Sensitivity::none, .max_events = 50}, transition);
  REQUIRE(transition.termination == Termination::event_limit);
}

TEST_CASE("a mass placed on its barrier at rest and pressed sticks at once and the map is zero") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"xi", 2.0}, {"r", 1.0}, {"k_r", 1.0}});
  Propagator propagator(system, p, {});
  HybridState state{0.0, vector({1.0, 0.0}), 0};  // in flight; Propagator::start would already hold it
  REQUIRE(propagator.start(0.0, state.x).mode == 1);
  REQUIRE(propagator.step(state, 1.0, Sensitivity::state) == StepEnd::event);
  REQUIRE(propagator.record().kind == EventKind::stick);
  REQUIRE(propagator.record().saltation.regular);
  REQUIRE(propagator.record().saltation.S == Matrix::Zero(2, 2));
  REQUIRE(state.mode == 1);
}

TEST_CASE("release from the barrier is continuous: S is exactly the identity") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"r", 0.5}, {"eta", 0.8}});
  const SaltationMatrix result = saltation_at(system, 1, std::acos(0.5) / 0.8, vector({0.5, 0.0}), p);
  REQUIRE(result.S == Matrix::Identity(2, 2));
  // It is the identity although the time of release depends on the parameters: the mass is then at rest without acceleration.
  REQUIRE(result.Sp == Matrix::Zero(2, 6));
  REQUIRE(result.transversality == Approx(0.8 * std::sin(std::acos(0.5))));
}

TEST_CASE("saltation with guards and resets that depend on time and parameters agrees with differences") {
  // A moving wall, h = x - r - A sin(w t), and a reset relative to its speed: v+ = u - k (v - u), u = A w cos(w t).
  enum : Eigen::Index { A, w, r, k, c };
  HybridSystem system;
  system.name = "moving-wall";
  system.states = 2;
  system.parameters = {support::detail::parameter("A", 0.2), support::detail::parameter("w", 1.3),
                       support::detail::parameter("r", 0.5), support::detail::parameter("k", 0.7),
                       support::detail::parameter("c", 0.4)};
  Mode mode;
  mode.name = "free";
  mode.field = [](double t, const Vector& x, const Vector& p, Vector& f) { f << x[1], -p[c] * x[0] * x[0] + 0.1 * std::sin(t); };
  mode.field_dx = [](double, const Vector& x, const Vector& p, Matrix& J) { J << 0.0, 1.0, -2.0 * p[c] * x[0], 0.0; };
  mode.field_dp = [](double, const Vector& x, const Vector&, Matrix& J) {
    J.setZero();
    J(1, c) = -x[0] * x[0];
  };
  mode.field_dt = [](double t, const Vector&, const Vector&, Vector& f) { f << 0.0, 0.1 * std::cos(t); };
  system.modes = {mode};
  Event event;
  event.name = "strike";
  event.kind = EventKind::impact;
  event.guard.value = [](double t, const Vector& x, const Vector& p) { return x[0] - p[r] - p[A] * std::sin(p[w] * t); };
  event.guard.dx = [](double, const Vector&, const Vector&, Vector& g) { g << 1.0, 0.0; };
  event.guard.dt = [](double t, const Vector&, const Vector& p) { return -p[A] * p[w] * std::cos(p[w] * t); };
  event.guard.dp = [](double t, const Vector&, const Vector& p, Vector& g) {
    g << -std::sin(p[w] * t), -p[A] * t * std::cos(p[w] * t), -1.0, 0.0, 0.0;
  };
  event.reset.map = [](double t, const Vector& x, const Vector& p, Vector& out) {
    out << x[0], (1.0 + p[k]) * p[A] * p[w] * std::cos(p[w] * t) - p[k] * x[1];
  };
  event.reset.dx = [](double, const Vector&, const Vector& p, Matrix& J) { J << 1.0, 0.0, 0.0, -p[k]; };
  event.reset.dt = [](double t, const Vector&, const Vector& p, Vector& out) {
    out << 0.0, -(1.0 + p[k]) * p[A] * p[w] * p[w] * std::sin(p[w] * t);
  };
  event.reset.dp = [](double t, const Vector& x, const Vector& p, Matrix& J) {
    const double cosine = std::cos(p[w] * t), sine = std::sin(p[w] * t);
    J.setZero();
    J(1, A) = (1.0 + p[k]) * p[w] * cosine;
    J(1, w) = (1.0 + p[k]) * p[A] * (cosine - p[w] * t * sine);
    J(1, k) = p[A] * p[w] * cosine - x[1];
  };
  system.events = {event};
  const Vector p = default_parameters(system.parameters);
  REQUIRE_THAT(check_mode(system, 0, 0.7, vector({0.3, -0.8}), p), all_agree());
  REQUIRE_THAT(check_event(system, 0, 0.7, vector({0.6, 0.8}), p), all_agree());
  const Vector x0 = vector({-0.4, 1.1});
  const Trajectory run = simulate(system, p, 0.2, x0, {.t_end = 2.2});
  REQUIRE(run.events.size() == 1);
  REQUIRE(run.events[0].normal_speed > 0.1);
  // Steps of 1e-4: truncation h^4 times fifth derivatives, rounding 1e-14/1e-4.
  REQUIRE_THAT(check_transition(system, p, 0.2, 2.2, x0, 1e-9), all_agree());
}

TEST_CASE("the second-derivative term of a curved or moving guard agrees with its formula") {
  // h = sqrt(x^2 + y^2) - R sin(w t). With f held fixed, D(h_x f + h_t) along (dt, dx, dR) has a closed form.
  Guard guard;
  guard.value = [](double t, const Vector& x, const Vector& p) { return x.norm() - p[0] * std::sin(p[1] * t); };
  guard.dx = [](double, const Vector& x, const Vector&, Vector& out) { out = x / x.norm(); };
  guard.dt = [](double t, const Vector&, const Vector& p) { return -p[0] * p[1] * std::cos(p[1] * t); };
  const double t = 0.7, R = 1.3, w = 2.1;
  const Vector x{{0.8, -0.5}}, f{{0.4, 1.1}}, d{{-0.3, 0.9}}, p{{R, w}};
  const double r = x.norm();
  const double bent = (f.dot(d) - x.dot(f) * x.dot(d) / (r * r)) / r;
  CHECK(std::abs(transversality_change(guard, t, x, f, p, 0.0, d) - bent) < 1e-10);
  CHECK(std::abs(transversality_change(guard, t, x, f, p, 1.0) - R * w * w * std::sin(w * t)) < 1e-10);
  CHECK(std::abs(transversality_change(guard, t, x, f, p, 0.0, {}, Vector{{1.0, 0.0}}) + w * std::cos(w * t)) < 1e-10);
  CHECK(transversality_change(make_level_guard({.coordinate = 0, .level = 0, .sign = 1.0}), t, x, f, p, 1.0, d) == 0.0);
}
