// SPDX-License-Identifier: GPL-3.0-or-later
// Mechanics as text: the built-in oscillators as one mass with one stop, chains, moving barriers, Kelvin-Voigt contacts, and
// the error messages.
#include "support/checks.hpp"
#include "support/hand_written.hpp"
#include "support/system_texts.hpp"

#include <graze/lib/lanes/oscillator.hpp>
#include <graze/lib/motion/rest.hpp>

#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

std::size_t mode_of(const HybridSystem& system, const std::string& name) {
  for (std::size_t i = 0; i < system.modes.size(); ++i)
    if (system.modes[i].name == name) return i;
  FAIL("no mode " << name);
  return 0;
}

}  // namespace

TEST_CASE("built-in oscillators as mechanics have the fields, guards, resets, sticking and structure of hand-written ones") {
  Random random(11);
  double worst = 0.0;
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      const HybridSystem given = hand_written_oscillator(kind, law);
      const HybridSystem read = make_oscillator(kind, law);
      INFO(given.name);
      REQUIRE(read.modes.size() == given.modes.size());
      REQUIRE(read.events.size() == given.events.size());
      for (int trial = 0; trial < 50; ++trial) {
        Vector p = default_parameters(given.parameters);
        for (double& value : p) value *= random(0.7, 1.0);
        const double r = p[oscillator_parameter::r], t = random(-3.0, 20.0);
        const Vector x = vector({r + random(-2.0, 2.0), random(-2.0, 2.0)});
        const Eigen::Index n = 2, np = p.size();
        for (std::size_t m = 0; m < read.modes.size(); ++m) {
          const Mode &a = given.modes[m], &b = read.modes[m];
          REQUIRE(b.name == a.name);
          worst = std::max(worst, distance(evaluate(a.field, t, x, p, n), evaluate(b.field, t, x, p, n)));
          worst = std::max(worst, distance(evaluate(a.field_dx, t, x, p, n), evaluate(b.field_dx, t, x, p, n)));
          worst = std::max(worst, distance(evaluate(a.field_dp, t, x, p, np), evaluate(b.field_dp, t, x, p, np)));
          worst = std::max(worst, distance(evaluate(a.field_dt, t, x, p, n), evaluate(b.field_dt, t, x, p, n)));
          REQUIRE(static_cast<bool>(a.structure) == static_cast<bool>(b.structure));
          if (a.structure) REQUIRE(a.structure(p).index() == b.structure(p).index());
        }
        for (std::size_t e = 0; e < read.events.size(); ++e) {
          const Event &a = given.events[e], &b = read.events[e];
          REQUIRE(b.name == a.name);
          REQUIRE(b.kind == a.kind);
          REQUIRE(b.from == a.from);
          REQUIRE(b.to == a.to);
          REQUIRE(b.continuous == a.continuous);
          REQUIRE(b.guard.level.has_value() == a.guard.level.has_value());
          if (a.guard.level) REQUIRE(b.guard.level->level == a.guard.level->level);
          worst = std::max(worst, std::abs(b.guard.value(t, x, p) - a.guard.value(t, x, p)));
          worst = std::max(worst, distance(evaluate(a.guard.dp, t, x, p, np), evaluate(b.guard.dp, t, x, p, np)));
          if (a.guard.dt) worst = std::max(worst, std::abs(a.guard.dt(t, x, p) - b.guard.dt(t, x, p)));
          REQUIRE(b.reset.rebound.has_value() == a.reset.rebound.has_value());
          REQUIRE(b.accumulation.has_value() == a.accumulation.has_value());
          REQUIRE(!b.effective_mass);
          if (a.log_volume_change) REQUIRE(a.log_volume_change(p) == b.log_volume_change(p));
          if (!a.accumulation) continue;
          const Reset &c = a.accumulation->reset, &d = b.accumulation->reset;
          REQUIRE(a.accumulation->sticking_mode == b.accumulation->sticking_mode);
          REQUIRE(evaluate(c.map, t, x, p, n) == evaluate(d.map, t, x, p, n));
          REQUIRE(evaluate(c.dx, t, x, p, n) == evaluate(d.dx, t, x, p, n));
          REQUIRE(evaluate(c.dp, t, x, p, np) == evaluate(d.dp, t, x, p, np));
        }
        for (const Vector& at : {x, vector({r, 0.7}), vector({r, -0.7}), vector({r, 0.0}), vector({r + 1e-13, 0.2})})
          REQUIRE(mode_at(read, t, at, p) == mode_at(given, t, at, p));
      }
    }
  }
  INFO("largest difference " << worst);
  REQUIRE(worst < 2e-14);
}

TEST_CASE("built-in oscillators as mechanics run with the bits of hand-written ones through chattering and sticking too") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      const HybridSystem given = hand_written_oscillator(kind, law);
      const HybridSystem read = make_oscillator(kind, law);
      INFO(given.name);
      const bool hard = law.name == "newton";
      Vector p = parameters(given, {{"xi", hard ? 3.0 : 1.2}, {"eta", hard ? 0.4 : 0.8}, {"r", 0.7}});
      if (hard) p[static_cast<Eigen::Index>(parameter_index(given.parameters, "k_r"))] = 0.5;
      REQUIRE(lanes::lanes_support(read, p));
      Propagator first(given, p, all_parameters(given)), second(read, p, all_parameters(read));
      Transition a, b;
      const Vector x0 = vector({0.1, 0.6});
      carry(first, 0.0, 3.0 * forcing_period(given, p), x0, {.keep_events = true}, a);
      carry(second, 0.0, 3.0 * forcing_period(read, p), x0, {}, b);
      REQUIRE(a.event_sequence.size() > 2);
      REQUIRE(a.event_sequence == b.event_sequence);
      if (hard)
        REQUIRE(
            std::any_of(a.events.begin(), a.events.end(), [](const EventRecord& one) { return one.kind == EventKind::release; }));
      REQUIRE(a.x1 == b.x1);
      REQUIRE(a.Phi == b.Phi);
      REQUIRE(a.Psi == b.Psi);
    }
  }
}

namespace {

/// Two masses, coupled by springs and through the mass matrix, with a stop at the second.
SystemWriter chain(const std::string& law, const std::vector<std::string>& values) {
  SystemWriter writer;
  writer.system.name = "chain";
  writer.forcing("eta");
  writer.parameter("m", "2").parameter("mu", "0.3").parameter("kappa", "0.5").parameter("c", "0.05").parameter("xi", "1");
  writer.parameter("eta", "0.711").parameter("r", "0.4").parameter("push", "0").parameter("k_r", "0.7");
  writer.parameter("k_H", "100").parameter("b_H", "0.1");
  writer.mechanics({"x1", "x2"}, {"v1", "v2"},
                   {{{"m", "mu"}, {"mu", "1"}},
                    {{"2*c", "-c"}, {"-c", "c"}},
                    {{"1 + kappa", "-kappa"}, {"-kappa", "kappa"}},
                    {"xi*cos(eta*t)", "push"}});
  writer.stop("wall", "r - x2", law, values);
  return writer;
}

}  // namespace

TEST_CASE("a chain at a rigid stop: the impulse conserves the momentum of the free coordinate and the loss is that of the "
          "effective mass") {
  const HybridSystem system = equations::make_system(chain("newton", {"k_r"}).system).system;
  REQUIRE(system.state_names == std::vector<std::string>{"x1", "x2", "v1", "v2"});
  REQUIRE(system.modes.size() == 2);
  REQUIRE(system.modes[1].name == "wall");
  const Vector p = default_parameters(system.parameters);
  const double m = p[0], mu = p[1], k_r = 0.7;
  const Vector x0 = vector({0.1, 0.2, 0.3, 0.5});
  for (std::size_t mode = 0; mode < 2; ++mode) REQUIRE_THAT(check_mode(system, mode, 0.4, x0, p), all_agree());
  for (std::size_t event = 0; event < 2; ++event) REQUIRE_THAT(check_event(system, event, 0.4, x0, p), all_agree());
  const double T = forcing_period(system, p);
  const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 6.0 * T});
  REQUIRE(run.events.size() > 5);
  for (const EventRecord& impact : run.events) {
    const Vector &a = impact.x_minus, &b = impact.x_plus;
    REQUIRE(b[1] == 0.4);
    REQUIRE(b[0] == a[0]);
    REQUIRE(m * a[2] + mu * a[3] == Approx(m * b[2] + mu * b[3]).margin(1e-14));
    REQUIRE(b[3] == Approx(-k_r * a[3]).epsilon(1e-13));
    REQUIRE(impact.mass == Approx(1.0 - mu * mu / m).epsilon(1e-14));
    const auto energy = [&](const Vector& x) { return 0.5 * (m * x[2] * x[2] + 2.0 * mu * x[2] * x[3] + x[3] * x[3]); };
    REQUIRE(energy(a) - energy(b) ==
            Approx(0.5 * impact.mass * (1.0 - k_r * k_r) * impact.normal_speed * impact.normal_speed).epsilon(1e-12));
  }
  REQUIRE_THAT(check_transition(system, p, 0.0, 2.0 * T, x0, 1e-7, 1e-5), all_agree());
  Propagator propagator(system, p);
  Transition transition;
  carry(propagator, 0.0, 2.0 * T, x0, {}, transition);
  REQUIRE(std::abs(transition.log_det - transition.liouville) < 1e-11);
}

TEST_CASE("a chain held at a rigid stop: the other mass moves on and the constraint force releases it") {
  const HybridSystem system = equations::make_system(chain("newton", {"k_r"}).system).system;
  const Vector p = parameters(system, {{"push", 0.8}, {"k_r", 0.3}});
  const double m = p[0], mu = p[1], kappa = p[2], c = p[3], xi = p[4], eta = p[5], r = p[6], push = 0.8,
               T = forcing_period(system, p);
  const Vector x0 = vector({0.1, 0.3, 0.0, 0.2});
  const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 4.0 * T});
  std::size_t sticks = 0;
  for (std::size_t i = 0; i + 1 < run.events.size(); ++i) {
    const EventRecord &stick = run.events[i], &release = run.events[i + 1];
    if (stick.kind != EventKind::stick || release.kind != EventKind::release) continue;
    ++sticks;
    REQUIRE(stick.x_plus[1] == r);
    REQUIRE(stick.x_plus[3] == 0.0);
    REQUIRE(release.x_minus[1] == r);
    REQUIRE(release.x_minus[3] == 0.0);
    // m x1'' is the sum of forces on x1; the force of the wall holds x2. Its sign is reversed here: lambda = mu x1'' - push -
    // kappa (x1 - r) - c v1 >= 0.
    double t = stick.t, x = stick.x_plus[0], v = stick.x_plus[2];
    const auto acceleration = [&](double s, double q, double u) {
      return (xi * std::cos(eta * s) - 2.0 * c * u - (1.0 + kappa) * q + kappa * r) / m;
    };
    const auto force = [&](double s, double q, double u) {  // force of the wall, positive while it presses
      return push + c * u - kappa * (r - q) - mu * acceleration(s, q, u);
    };
    const int steps = 4000;
    const double h = (release.t - stick.t) / steps;
    for (int k = 0; k < steps; ++k) {
      REQUIRE(force(t, x, v) > -1e-9);
      const double k1 = v, l1 = acceleration(t, x, v);
      const double k2 = v + 0.5 * h * l1, l2 = acceleration(t + 0.5 * h, x + 0.5 * h * k1, k2);
      const double k3 = v + 0.5 * h * l2, l3 = acceleration(t + 0.5 * h, x + 0.5 * h * k2, k3);
      const double k4 = v + h * l3, l4 = acceleration(t + h, x + h * k3, k4);
      x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
      t += h;
    }
    REQUIRE(x == Approx(release.x_minus[0]).margin(1e-10));
    REQUIRE(v == Approx(release.x_minus[2]).margin(1e-10));
    REQUIRE(std::abs(force(t, x, v)) < 1e-9);
  }
  REQUIRE(sticks > 0);
}

TEST_CASE("the derivative through a whole series of impacts of a chain agrees with differences") {
  const HybridSystem system = equations::make_system(chain("newton", {"k_r"}).system).system;
  const Vector p = parameters(system, {{"push", 0.8}, {"k_r", 0.3}});
  const Vector x0 = vector({0.1, 0.3, 0.0, 0.2});
  const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 40.0});
  const auto stick =
      std::find_if(run.events.begin(), run.events.end(), [](const EventRecord& one) { return one.kind == EventKind::stick; });
  REQUIRE(stick != run.events.end());
  const double t_end = stick->t + 0.05;
  Propagator propagator(system, p), probe(system, p);
  Transition transition, moved;
  carry(propagator, 0.0, t_end, x0, {}, transition);
  REQUIRE(transition.termination == Termination::time);
  REQUIRE(transition.Phi.row(1).isZero(0.0));
  REQUIRE(transition.Phi.row(3).isZero(0.0));
  const double step = 1e-5;
  for (Eigen::Index k = 0; k < 4; ++k) {
    Vector difference = Vector::Zero(4);
    for (const double sign : {1.0, -1.0}) {
      Vector x = x0;
      x[k] += sign * step;
      carry(probe, 0.0, t_end, x, {.sensitivity = Sensitivity::none}, moved);
      difference += sign * moved.x1 / (2.0 * step);
    }
    INFO(k << ": " << (difference - transition.Phi.col(k)).transpose());
    REQUIRE((difference - transition.Phi.col(k)).lpNorm<Eigen::Infinity>() < 2e-5);
  }
}

TEST_CASE("the derivative of a chain that is held all the time agrees with differences") {
  const HybridSystem system = equations::make_system(chain("newton", {"k_r"}).system).system;
  const Vector p = parameters(system, {{"push", 5.0}, {"k_r", 0.3}});
  const Vector x0 = vector({0.1, 0.4, 0.2, 0.0});
  const double t_end = 5.0, step = 1e-5;
  Propagator propagator(system, p, all_parameters(system)), probe(system, p);
  Transition transition, moved;
  carry(propagator, 0.0, t_end, x0, {.sensitivity = Sensitivity::state_and_parameters, .keep_factors = true}, transition);
  REQUIRE(transition.event_sequence.empty());
  REQUIRE(system.modes[transition.mode1].name == "wall");
  Matrix product = Matrix::Identity(4, 4);
  for (const Matrix& factor : transition.factors) product = factor * product;
  REQUIRE(distance(product, transition.Phi) < 1e-14);
  for (Eigen::Index k = 0; k < 4; ++k) {
    // Differences off the wall only, not into it. From a distance s the mass falls back in a time of order sqrt(s), which is
    // the error.
    double error[2];
    for (const int i : {0, 1}) {
      const double s = i == 0 ? 1e-5 : 1e-7;
      Vector x = x0;
      x[k] -= s;
      carry(probe, 0.0, t_end, x, {.sensitivity = Sensitivity::none}, moved);
      error[i] = ((transition.x1 - moved.x1) / s - transition.Phi.col(k)).lpNorm<Eigen::Infinity>();
    }
    INFO(k << ": " << error[0] << ", " << error[1]);
    REQUIRE(error[0] < (k == 1 ? 2e-3 : 1e-4));
    REQUIRE(error[1] < (k == 1 ? 2e-4 : 1e-4));
  }
  for (Eigen::Index k = 0; k < p.size(); ++k) {
    if (system.parameters[static_cast<std::size_t>(k)].name == "r") continue;  // r would move the start
    Vector q = p, after[2];
    for (const int i : {0, 1}) {
      q[k] = p[k] + (i == 0 ? step : -step);
      probe.set_parameters(q);
      carry(probe, 0.0, t_end, x0, {.sensitivity = Sensitivity::none}, moved);
      after[i] = moved.x1;
    }
    INFO(system.parameters[static_cast<std::size_t>(k)].name);
    REQUIRE(((after[0] - after[1]) / (2.0 * step) - transition.Psi.col(k)).lpNorm<Eigen::Infinity>() < 1e-6);
  }
}

TEST_CASE("a chain at a Hertz stop as a force: continuous, exact derivatives, energy conserved without damping") {
  const HybridSystem written = equations::make_system(chain("force", {"k_H*d^(3/2)*(1 + b_H*d')"}).system).system;
  const HybridSystem named = equations::make_system(chain("hertz", {"k_H", "b_H"}).system).system;
  REQUIRE(written.modes.size() == 2);
  const Vector p = default_parameters(written.parameters), x = vector({0.1, 0.7, 0.3, -0.5});
  for (std::size_t mode = 0; mode < 2; ++mode) {
    REQUIRE(distance(evaluate(written.modes[mode].field, 0.4, x, p, 4), evaluate(named.modes[mode].field, 0.4, x, p, 4)) < 1e-15);
    REQUIRE_THAT(check_mode(written, mode, 0.4, x, p), all_agree());
    REQUIRE(written.events[mode].continuous);
    REQUIRE(written.events[mode].guard.level.has_value());
    REQUIRE_THAT(check_event(written, mode, 0.4, x, p), all_agree());
  }
  REQUIRE(!has_hard_contacts(written));
  REQUIRE_THAT(check_transition(written, p, 0.0, 12.0, vector({0.1, 0.2, 0.3, 0.5}), 1e-6, 1e-5), all_agree());
  const Vector q = parameters(written, {{"c", 0.0}, {"xi", 0.0}, {"b_H", 0.0}});
  const auto energy = [&](const Vector& z) {
    const double kinetic = 0.5 * (2.0 * z[2] * z[2] + 0.6 * z[2] * z[3] + z[3] * z[3]);
    const double spring = 0.5 * (1.5 * z[0] * z[0] - z[0] * z[1] + 0.5 * z[1] * z[1]);
    return kinetic + spring + 0.4 * 100.0 * std::pow(std::max(0.0, z[1] - 0.4), 2.5);
  };
  const Vector x0 = vector({0.1, 0.2, 0.3, 0.9});
  const Trajectory run = simulate(written, q, 0.0, x0, {.t_end = 40.0});
  REQUIRE(run.events.size() > 6);
  REQUIRE(energy(run.x) == Approx(energy(x0)).epsilon(1e-8));
  // One mass: the structure is recognised, with bits identical to those of the built-in law.
  SystemWriter writer;
  writer.system = oscillator_mechanics(oscillator_kind("linear"), contact_law("hertz"));
  const HybridSystem one = equations::make_system(writer.system).system;
  writer.system.stops[0].law.text = "force";
  writer.system.stops[0].values = {writer.write("k_H*d^(3/2)*(1 + b_H*d')")};
  const HybridSystem other = equations::make_system(writer.system).system;
  const Vector s = default_parameters(one.parameters);
  REQUIRE(std::holds_alternative<HertzContact>(other.modes[1].structure(s)));
  REQUIRE(simulate(one, s, 0.0, vector({1.9, 1.0}), {.t_end = 20.0}).x ==
          simulate(other, s, 0.0, vector({1.9, 1.0}), {.t_end = 20.0}).x);
}

namespace {

HybridSystem ball_on_table() {
  SystemWriter writer;
  writer.system.name = "ball";
  writer.forcing("omega").parameter("g", "1").parameter("A", "0.5").parameter("omega", "1").parameter("e", "0.8");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {}, {}, {"-g"}});
  writer.stop("table", "x - A*sin(omega*t)", "newton", {"e"});
  return equations::make_system(writer.system).system;
}

}  // namespace

TEST_CASE("a ball on a shaking table: the 1/1 orbit impacts at the phase of its closed form") {
  const HybridSystem system = ball_on_table();
  const Vector p = default_parameters(system.parameters);
  const double A = 0.5, e = 0.8, T = 2.0 * std::numbers::pi, Gamma = A;
  const double phase = std::acos(std::numbers::pi * (1.0 - e) / (1.0 + e) / Gamma);
  const Vector x0 = vector({A * std::sin(phase), 0.5 * T});
  const Trajectory run = simulate(system, p, phase, x0, {.t_end = phase + 5.5 * T});
  REQUIRE(run.events.size() == 5);
  for (std::size_t i = 0; i < run.events.size(); ++i) {
    const EventRecord& impact = run.events[i];
    REQUIRE(impact.kind == EventKind::impact);
    REQUIRE(impact.t == Approx(phase + static_cast<double>(i + 1) * T).epsilon(1e-11));
    REQUIRE(impact.x_plus[1] == Approx(0.5 * T).epsilon(1e-10));
    REQUIRE(impact.x_plus[0] == A * std::sin(impact.t));
  }
  // Free flights preserve the volume; an impact multiplies it by e^2.
  Propagator propagator(system, p);
  Transition transition;
  carry(propagator, phase + 0.5, phase + 0.5 + T, vector({A * std::sin(phase) + 0.25 * T - 0.125, 0.5 * T - 0.5}), {},
        transition);
  REQUIRE(transition.event_sequence.size() == 1);
  REQUIRE(transition.Phi.determinant() == Approx(e * e).epsilon(1e-11));
  REQUIRE(transition.liouville == Approx(2.0 * std::log(e)).epsilon(1e-12));
  REQUIRE_THAT(check_mode(system, 0, 0.4, x0, p), all_agree());
  REQUIRE_THAT(check_mode(system, 1, 0.4, x0, p), all_agree());
  REQUIRE_THAT(check_event(system, 0, 0.4, x0, p), all_agree());
  REQUIRE_THAT(check_event(system, 1, 0.4, x0, p), all_agree());
  REQUIRE_THAT(check_transition(system, p, phase + 0.5, phase + 2.5 * T, vector({x0[0] + 0.5, 0.5 * T}), 1e-7, 1e-5),
               all_agree());
}

TEST_CASE("a ball on a shaking table: complete chattering, rest on the moving table, release where it falls faster than g") {
  const HybridSystem system = ball_on_table();
  const Vector p = parameters(system, {{"A", 1.2}, {"e", 0.3}});
  const double A = 1.2, T = 2.0 * std::numbers::pi;
  const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.0}), {.t_end = 3.0 * T});
  std::size_t releases = 0;
  for (std::size_t i = 0; i < run.events.size(); ++i) {
    const EventRecord& one = run.events[i];
    if (one.kind == EventKind::stick) REQUIRE(one.x_plus == vector({A * std::sin(one.t), A * std::cos(one.t)}));
    if (one.kind != EventKind::release) continue;
    ++releases;
    REQUIRE(run.events[i - 1].kind == EventKind::stick);
    REQUIRE(std::sin(one.t) == Approx(1.0 / A).epsilon(1e-10));
    REQUIRE(one.x_minus[0] == Approx(A * std::sin(one.t)).margin(1e-11));
    REQUIRE(one.x_minus[1] == Approx(A * std::cos(one.t)).margin(1e-11));
  }
  REQUIRE(releases >= 2);
  // At rest on the table from then on, if the table never falls faster than g. The start is forgotten: the multipliers are
  // exactly zero.
  const Vector q = parameters(system, {{"A", 0.9}, {"e", 0.3}});
  Propagator propagator(system, q);
  Transition transition;
  carry(propagator, 0.0, 3.0 * T, vector({1.0, 0.0}), {}, transition);
  REQUIRE(transition.termination == Termination::time);
  REQUIRE(transition.Phi.isZero(0.0));
  REQUIRE(transition.x1[0] == Approx(0.0).margin(1e-10));
  REQUIRE(transition.x1[1] == Approx(0.9).epsilon(1e-10));
  REQUIRE(system.modes[transition.mode1].name == "table");
  const auto rest = permanent_rest(propagator, vector({0.1, 0.5}));
  REQUIRE(rest == vector({0.0, 0.9}));
  REQUIRE(reaches_rest(propagator, transition.x1, *rest));
  // The rounding of the integration does not lift the ball off the table or push it in, period by period.
  for (int period = 0; period < 200; ++period) {
    const Vector x = transition.x1;
    carry(propagator, 0.0, T, x, {}, transition);
    REQUIRE(transition.termination == Termination::time);
    REQUIRE(transition.event_sequence.empty());
  }
}

TEST_CASE("a soft contact with a moving barrier has exact derivatives and the depth of the moving gap") {
  for (const bool damped : {false, true}) {
    SystemWriter writer;
    writer.system.name = "soft-table";
    writer.forcing("omega")
        .parameter("g", "1")
        .parameter("A", "0.3")
        .parameter("omega", "1")
        .parameter("k", "200")
        .parameter("c", "2");
    writer.mechanics({"x"}, {"v"}, {{{"1"}}, {}, {}, {"-g"}});
    if (damped) {
      writer.stop("table", "x - A*sin(omega*t)", "linear", {"k", "c"});
    } else {
      writer.stop("table", "x - A*sin(omega*t)", "hertz", {"k"});
    }
    const HybridSystem system = equations::make_system(writer.system).system;
    const Vector p = default_parameters(system.parameters), x0 = vector({0.5, 0.3});
    for (std::size_t mode = 0; mode < system.modes.size(); ++mode)
      REQUIRE_THAT(check_mode(system, mode, 0.4, vector({0.05, 0.3}), p), all_agree());
    for (std::size_t event = 0; event < system.events.size(); ++event)
      REQUIRE_THAT(check_event(system, event, 0.4, vector({0.05, 0.3}), p), all_agree());
    const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 6.0});
    REQUIRE(run.events.size() >= (damped ? 3 : 2));
    REQUIRE(run.events[0].x_minus[0] == Approx(0.3 * std::sin(run.events[0].t)).margin(1e-12));
    REQUIRE_THAT(check_transition(system, p, 0.0, 6.0, x0, 1e-6, 1e-5), all_agree());
  }
}

TEST_CASE("a Kelvin-Voigt stop ends where its force vanishes or with adhesion where the gap opens") {
  const double k = 100.0, c = 4.0, a = 0.5 * c, w = std::sqrt(k - a * a), speed = 1.0;
  const auto depth_rate = [&](double t) { return speed * std::exp(-a * t) * (std::cos(w * t) - a / w * std::sin(w * t)); };
  const auto depth = [&](double t) { return speed / w * std::exp(-a * t) * std::sin(w * t); };
  for (const bool adhesion : {false, true}) {
    SystemWriter writer;
    writer.system.name = "kelvin-voigt";
    writer.parameter("k", "100").parameter("c", "4").parameter("r", "0");
    writer.mechanics({"x"}, {"v"}, {{{"1"}}}).stop("wall", "r - x", "linear", {"k", "c"}, adhesion);
    const HybridSystem system = equations::make_system(writer.system).system;
    const Vector p = default_parameters(system.parameters);
    REQUIRE(system.modes.size() == (adhesion ? 2 : 3));
    const Trajectory run = simulate(system, p, 0.0, vector({-0.5, speed}), {.t_end = 3.0});
    REQUIRE(run.events.size() == (adhesion ? 2 : 3));
    REQUIRE(run.events[0].kind == EventKind::enter);
    REQUIRE(run.events[1].kind == EventKind::leave);
    const double duration = adhesion ? std::numbers::pi / w : std::atan2(2.0 * a * w, a * a - w * w) / w;
    REQUIRE(run.events[1].t - run.events[0].t == Approx(duration).epsilon(1e-10));
    REQUIRE(run.events[1].x_plus[0] == Approx(adhesion ? 0.0 : depth(duration)).margin(1e-11));
    REQUIRE(run.x[1] == Approx(depth_rate(duration)).epsilon(1e-10));
    REQUIRE(system.modes[run.mode].name == "free");
    // The force jumps where the contact begins, and the derivative includes the jump.
    REQUIRE(!system.events[0].continuous);
    REQUIRE_THAT(check_transition(system, p, 0.0, 2.0, vector({-0.5, speed}), 1e-8, 1e-5), all_agree());
    for (std::size_t mode = 0; mode < system.modes.size(); ++mode)
      REQUIRE_THAT(check_mode(system, mode, 0.0, vector({0.01, 0.3}), p), all_agree());
    for (std::size_t event = 0; event < system.events.size(); ++event)
      REQUIRE_THAT(check_event(system, event, 0.0, vector({0.01, 0.3}), p), all_agree());
  }
}

TEST_CASE("a stop with a damper acts alike whatever the unit of force") {
  const auto contacts = [](const std::string& unit, const std::string& law) {
    SystemWriter writer;
    writer.system.name = "units";
    writer.forcing("w").parameter("w", "0.8").parameter("s", unit);
    writer.mechanics({"x"}, {"v"}, {{{"s"}}, {{"0.04*s"}}, {{"s"}}, {"s*cos(w*t)"}});
    if (law == "linear")
      writer.stop("wall", "0.9 - x", "linear", {"30*s", "0.5*s"});
    else
      writer.stop("wall", "0.9 - x", "force", {"s*(30*d + 0.5*d')"});
    const HybridSystem system = equations::make_system(writer.system).system;
    return simulate(system, default_parameters(system.parameters), 0.0, vector({0.0, 0.0}), {.t_end = 200.0});
  };
  for (const char* law : {"linear", "force"}) {
    const Trajectory one = contacts("1", law);
    REQUIRE(one.events.size() > 50);
    for (const char* unit : {"1e-6", "1e-3", "17", "1e3", "1.5e5", "1e9"}) {
      INFO(law << ", unit " << unit);
      const Trajectory other = contacts(unit, law);
      REQUIRE(other.termination == Termination::time);
      REQUIRE(other.events.size() == one.events.size());
      for (std::size_t k = 0; k < one.events.size(); ++k) {
        REQUIRE(other.events[k].event == one.events[k].event);
        REQUIRE(other.events[k].t == Approx(one.events[k].t).margin(1e-8));
      }
    }
  }
}

TEST_CASE("the force of a stop may bend beside other functions that do") {
  for (const char* law : {"20*min(d, 0.1)", "clamp(20*d, 0, 2)", "20*d + deadzone(d, 0.15)", "20*d + 5*step(d - 0.1)"}) {
    INFO(law);
    SystemWriter writer;
    writer.forcing("w").parameter("w", "0.8");
    writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.04"}}, {{"1"}}, {"cos(w*t) - 0.1*abs(v)*v + 0.1*sign(x)"}});
    writer.stop("right", "0.9 - x", "force", {law}).stop("left", "x + 1.2", "newton", {"0.7"});
    const HybridSystem system = equations::make_system(writer.system).system;
    const Vector p = default_parameters(system.parameters);
    REQUIRE_THAT(check_transition(system, p, 0.0, 6.0, vector({0.3, 0.8}), 1e-8, 1e-5), all_agree());
  }
}

TEST_CASE("several stops: modes are the combinations of closed contacts and dependent constraints give none") {
  SystemWriter writer;
  writer.system.name = "two-sided";
  writer.forcing("eta")
      .parameter("xi", "1")
      .parameter("eta", "0.8")
      .parameter("r", "0.6")
      .parameter("k_r", "0.5")
      .parameter("k", "30");
  writer.mechanics({"x", "y"}, {"v", "w"}, {{{"1", "0"}, {"0", "2"}}, {}, {{"1", "0"}, {"0", "1"}}, {"xi*cos(eta*t)", "0"}});
  writer.stop("left", "x + r", "newton", {"k_r"})
      .stop("right", "r - x", "newton", {"k_r"})
      .stop("soft", "y - x + r", "linear", {"k"});
  const HybridSystem system = equations::make_system(writer.system).system;
  std::vector<std::string> names;
  for (const Mode& mode : system.modes) names.push_back(mode.name);
  REQUIRE(names == std::vector<std::string>{"free", "left", "right", "soft", "left+soft", "right+soft"});
  const Vector p = default_parameters(system.parameters);
  REQUIRE(mode_at(system, 0.0, vector({0.0, 0.0, 0.1, 0.1}), p) == 0);
  REQUIRE(mode_at(system, 0.0, vector({0.2, -0.5, 0.1, 0.1}), p) == mode_of(system, "soft"));
  REQUIRE(mode_at(system, 0.0, vector({0.6, 0.5, 0.0, 0.0}), p) == mode_of(system, "right"));
  REQUIRE(!mode_at(system, 0.0, vector({0.7, 0.5, 0.0, 0.0}), p));
  const Vector x = vector({0.2, -0.5, 0.1, 0.1});
  for (std::size_t mode = 0; mode < system.modes.size(); ++mode) REQUIRE_THAT(check_mode(system, mode, 0.3, x, p), all_agree());
  for (std::size_t event = 0; event < system.events.size(); ++event)
    REQUIRE_THAT(check_event(system, event, 0.3, x, p), all_agree());
  const Trajectory run = simulate(system, p, 0.0, vector({0.0, 0.0, 0.5, 0.3}), {.t_end = 60.0});
  REQUIRE(run.termination == Termination::time);
  REQUIRE(run.events.size() > 10);
}

TEST_CASE("two masses that collide: momentum is conserved through chattering and joint motion until they separate") {
  SystemWriter writer;
  writer.system.name = "pair";
  writer.forcing("w").parameter("m", "2").parameter("k", "3").parameter("F", "4").parameter("w", "1").parameter("k_r", "0.4");
  // A constant attraction, and a force that pulls them apart from time to time. The gap is that between the masses.
  writer.mechanics({"x", "y"}, {"v", "u"}, {{{"m", "0"}, {"0", "1"}}, {}, {}, {"k - F*sin(w*t)", "F*sin(w*t) - k"}});
  writer.stop("meeting", "y - x", "newton", {"k_r"});
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = default_parameters(system.parameters), x0 = vector({0.0, 0.3, 0.5, -0.2});
  const double momentum = 2.0 * 0.5 - 0.2, released = std::asin(3.0 / 4.0);
  const Trajectory run = simulate(system, p, std::numbers::pi, x0, {.t_end = 25.0});
  REQUIRE(run.termination == Termination::time);
  std::size_t releases = 0;
  for (const EventRecord& one : run.events) {
    REQUIRE(2.0 * one.x_plus[2] + one.x_plus[3] == Approx(momentum).epsilon(1e-11));
    REQUIRE((2.0 * one.x_plus[0] + one.x_plus[1]) == Approx(0.3 + momentum * (one.t - std::numbers::pi)).epsilon(1e-11));
    REQUIRE(one.mass == Approx(one.kind == EventKind::release ? 1.0 : 2.0 / 3.0));
    if (one.kind == EventKind::stick) {
      REQUIRE(one.x_plus[2] == one.x_plus[3]);
      REQUIRE(one.x_plus[0] == one.x_plus[1]);
    }
    if (one.kind != EventKind::release) continue;
    ++releases;
    REQUIRE(std::remainder(one.t - released, 2.0 * std::numbers::pi) == Approx(0.0).margin(1e-10));
    REQUIRE(one.x_minus[0] == Approx(one.x_minus[1]).epsilon(1e-12));
  }
  REQUIRE(releases > 1);
}

TEST_CASE("a mass dropped on another one on the floor: both come to rest in finite time") {
  SystemWriter writer;
  writer.system.name = "stack";
  writer.parameter("m", "2").parameter("g", "1").parameter("k_r", "0.4");
  writer.mechanics({"x", "y"}, {"v", "w"}, {{{"1", "0"}, {"0", "m"}}, {}, {}, {"-g", "-m*g"}});
  writer.stop("floor", "x", "newton", {"k_r"}).stop("stack", "y - x", "newton", {"k_r"});
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = default_parameters(system.parameters);
  const Trajectory run = simulate(system, p, 0.0, vector({0.0, 1.0, 0.0, 0.0}), {.t_end = 10.0, .max_events = 3000});
  REQUIRE(run.termination == Termination::time);
  REQUIRE(run.events[0].t == Approx(std::sqrt(2.0)).epsilon(1e-11));
  REQUIRE(system.modes[run.mode].name == "floor+stack");
  REQUIRE(run.x == vector({0.0, 0.0, 0.0, 0.0}));
  double energy = 2.0;
  for (const EventRecord& one : run.events) {
    const Vector& z = one.x_plus;
    const double now = 0.5 * z[2] * z[2] + z[3] * z[3] + z[0] + 2.0 * z[1];
    REQUIRE(now <= energy + 1e-12);
    energy = now;
  }
}

TEST_CASE("stops that are hit together impact in the order of the file") {
  SystemWriter writer;
  writer.system.name = "together";
  writer.parameter("r", "1").parameter("k_r", "0.5");
  writer.mechanics({"x", "y"}, {"v", "w"}, {{{"1", "0"}, {"0", "1"}}});
  writer.stop("second", "r - y", "newton", {"k_r"}).stop("first", "r - x", "newton", {"k_r"});
  writer.system.stops[0].count = 1;
  const equations::TextSystem read = equations::make_system(writer.system);
  const HybridSystem& system = read.system;
  const Trajectory run =
      simulate(system, default_parameters(system.parameters), 0.0, vector({0.0, 0.0, 1.0, 1.0}), {.t_end = 1.5});
  REQUIRE(run.events.size() == 2);
  REQUIRE(system.events[run.events[0].event].name == "second");
  REQUIRE(system.events[run.events[1].event].name == "first");
  REQUIRE(read.events[run.events[0].event].count == 1);
  REQUIRE(read.events[run.events[1].event].count == 0);
  REQUIRE(run.events[0].t == run.events[1].t);
  REQUIRE(run.x.isApprox(vector({0.75, 0.75, -0.5, -0.5}), 1e-12));
}

TEST_CASE("a cart with a pendulum at a curved stop has exact derivatives") {
  SystemWriter writer;
  writer.system.name = "pendulum";
  writer.forcing("eta")
      .parameter("m", "0.5")
      .parameter("a", "0.7")
      .parameter("eta", "1.1")
      .parameter("k_r", "0.6")
      .parameter("r", "0.8");
  // A cart and a pendulum; the force contains the Coriolis terms.
  writer.mechanics({"x", "phi"}, {"v", "w"},
                   {{{"1 + m", "m*cos(phi)"}, {"m*cos(phi)", "m"}},
                    {},
                    {{"1", "0"}, {"0", "0"}},
                    {"m*w^2*sin(phi) + a*cos(eta*t) - 0.1*v*abs(v)", "-m*sin(phi) - 0.05*w"}});
  writer.stop("wall", "r - x - sin(phi)", "newton", {"k_r"});
  const equations::TextSystem read = equations::make_system(writer.system);
  const HybridSystem& system = read.system;
  const Vector p = default_parameters(system.parameters), x = vector({0.2, 0.3, 0.4, 0.5});
  for (std::size_t mode = 0; mode < system.modes.size(); ++mode) REQUIRE_THAT(check_mode(system, mode, 0.3, x, p), all_agree());
  for (std::size_t event = 0; event < system.events.size(); ++event)
    REQUIRE_THAT(check_event(system, event, 0.3, x, p), all_agree());
  const double t_end = 8.0;
  const Trajectory run = simulate(system, p, 0.0, x, {.t_end = t_end});
  REQUIRE(run.termination == Termination::time);
  REQUIRE(std::count_if(run.events.begin(), run.events.end(),
                        [](const EventRecord& one) { return one.kind == EventKind::impact; }) > 0);
  REQUIRE_THAT(check_transition(system, p, 0.0, t_end, x, 1e-6, 1e-5), all_agree());
}

namespace {

SystemWriter two(const SystemWriter::Rows& mass) {
  SystemWriter writer;
  writer.system.name = "two";
  writer.parameter("m", "1").mechanics({"x", "y"}, {"v", "w"}, {mass});
  return writer;
}

}  // namespace

TEST_CASE("each mistake in mechanics gives one sentence with its place") {
  // Lines: 1, 2 the parameter, 3 [mechanics], 4 to 7 the names, 8 to 11 the mass matrix, then the tested text.
  const SystemWriter::Rows unit = {{"1", "0"}, {"0", "1"}};
  REQUIRE(mistake(two({{"m", "1"}, {"1", "1"}}).system) ==
          "system.toml:11:1: the mass matrix is singular or not positive definite at the default parameters (row 2)");
  REQUIRE(mistake(two({{"x", "0"}, {"0", "1"}}).start("x", "0").start("y", "0").start("v", "0").start("w", "0").system) ==
          "system.toml:8:1: the mass matrix is singular or not positive definite at the start (row 1)");
  REQUIRE(mistake(two({{"1", "2"}, {"m", "1"}}).system) ==
          "system.toml:10:1: the mass matrix is not symmetric: row 2, column 1 is 1, row 1, column 2 is 2");
  REQUIRE(mistake(two({{"1", "0"}, {"0", "1 + v"}}).system) == "system.toml:11:1: the mass matrix depends on the velocity v");
  REQUIRE(mistake(two({{"1", "0"}}).system) ==
          "system.toml:8:1: the mass matrix has 1 row; it needs 2 rows of 2 entries, as there are 2 coordinates");
  REQUIRE(mistake(two({{"1", "0"}, {"0"}}).system) ==
          "system.toml:10:1: row 2 of the mass matrix has 1 entry; it needs 2 rows of 2 entries, as there are 2 coordinates");
  REQUIRE(mistake(two(unit).stop("wall", "1 - v", "newton", {"1"}).system) ==
          "system.toml:13:1: the gap of wall depends on the velocity v");
  REQUIRE(mistake(two(unit).stop("wall", "m", "newton", {"1"}).system) ==
          "system.toml:13:1: the gap of wall depends on no coordinate");
  REQUIRE(mistake(two(unit).stop("wall", "1 - z", "newton", {"1"}).system) ==
          "system.toml:13:5: unknown name 'z' in the gap of wall");
  REQUIRE(mistake(two(unit).stop("wall", "1 - x/(m - 1)", "newton", {"1"}).system) ==
          "system.toml:13:7: the divisor m - 1 is zero at the default parameters");
  REQUIRE(mistake(two(unit).stop("wall", "1 - x", "newtn", {"1"}).system) ==
          "system.toml:14:1: the stop wall has an unknown law 'newtn'; did you mean 'newton'?");
  REQUIRE(mistake(two(unit).stop("wall", "1 - x", "newton", {"1", "2"}).system) ==
          "system.toml:14:1: the law newton of the stop wall has 2 values; it takes k_r");
  REQUIRE(mistake(two(unit).stop("wall", "1 - x", "force", {"sqrt(d)"}).system) ==
          "system.toml:15:1: the power of x - 1 has an infinite derivative at the guard through which mode wall is entered");
  REQUIRE(mistake(two(unit).stop("wall", "1 - x", "linear", {"1"}).stop("wall", "1 - y", "linear", {"1"}).system) ==
          "system.toml:16:1: a stop or friction called 'wall' exists already");
  REQUIRE(mistake(two(unit).stop("wall", "1 - x + sin(t)", "newton", {"1"}).system) ==
          "system.toml:13:1: the guard of wall depends on the time, but neither a forcing frequency nor a period is given");
  SystemWriter many = two(unit);
  for (int i = 0; i < 9; ++i) many.stop("s" + std::to_string(i), "1 - x", "linear", {"1"});
  REQUIRE(mistake(many.system) == "system.toml:44:1: stops and friction up to s8 make 512 modes; at most 256 are made");
  // The sliding speed u, a velocity of the same name, and the rate of a velocity.
  const auto slides = [&](const std::string& law, const std::string& velocity) {
    SystemWriter writer;
    writer.parameter("m", "1").mechanics({"x"}, {velocity}, {{{"m"}}});
    return mistake(writer.friction("rail", velocity, "1", law).system);
  };
  REQUIRE(slides("0.3", "u") == "none");
  REQUIRE(slides("0.3/(1 + u)", "v") == "none");
  REQUIRE(slides("0.3/(1 + u)", "u") ==
          "system.toml:10:10: the name 'u' has a meaning of its own, and another one in the file, which must be renamed, in the "
          "law of rail");
  REQUIRE(slides("0.3 + 0.1*v'", "v") == "system.toml:10:11: an acceleration, the rate of v, stands in the law of rail");
  REQUIRE(slides("-0.1", "v") == "system.toml:10:1: the coefficient of the friction rail is -0.1; allowed is >= 0");
  REQUIRE(mistake(two(unit).stop("wall", "1 - x", "linear", {"-3"}).system) ==
          "system.toml:15:1: the stiffness k of the stop wall is -3; allowed is >= 0");
  REQUIRE(mistake(two(unit).stop("wall", "1 - x", "linear", {"3", "-1"}).system) ==
          "system.toml:16:1: the damping c of the stop wall is -1; allowed is >= 0");
  // Twice the same sliding; a wall and a belt that moves along it are two.
  REQUIRE(mistake(two(unit).friction("a", "v - w", "1", "0.3").friction("b", "2*w - 2*v", "1", "0.1").system) ==
          "system.toml:17:1: b slides whenever a does, at the same speed or a multiple of it: which of them holds is not "
          "determined; write one friction with the sum of their forces");
  REQUIRE(mistake(two(unit).friction("a", "v", "1", "0.3").friction("b", "v - m", "1", "0.1").system) == "none");
  SystemWriter none;
  none.states({"x"}).mode("free", "x' = -x").stop("wall", "1 - x", "newton", {"1"});
  REQUIRE(mistake(none.system) == "system.toml:4:1: a stop needs mechanics, with coordinates and a mass matrix");
  SystemWriter both = two(unit);
  both.mode("free", "x' = v");
  REQUIRE(mistake(both.system) == "system.toml:12:1: both modes and mechanics are given; the modes follow from the mechanics");
}
