// SPDX-License-Identifier: GPL-3.0-or-later
// The built-in oscillators written as modes and events in text. They must have the fields, derivatives, guards, resets,
// structures and motions of hand-written functions.
#include "support/checks.hpp"
#include "support/hand_written.hpp"
#include "support/system_texts.hpp"

#include <graze/lib/lanes/oscillator.hpp>

using namespace graze;
using namespace graze::support;

namespace {

Vector draw(const HybridSystem& system, Random& random) {
  Vector p = default_parameters(system.parameters);
  for (double& value : p) value *= random(0.7, 1.3);
  for (Eigen::Index i = 0; i < p.size(); ++i) p[i] = std::min(p[i], system.parameters[static_cast<std::size_t>(i)].upper);
  return p;
}

void require_equal(const ModeStructure& a, const ModeStructure& b) {
  REQUIRE(a.index() == b.index());
  if (const auto* p = std::get_if<LinearOscillator>(&a)) {
    const auto& q = std::get<LinearOscillator>(b);
    REQUIRE(p->damping == q.damping);
    REQUIRE(p->stiffness == q.stiffness);
    REQUIRE(p->amplitude == q.amplitude);
    REQUIRE(p->frequency == q.frequency);
    REQUIRE(p->constant == q.constant);
    REQUIRE(p->dp == q.dp);
    REQUIRE(p->not_differentiable_in == q.not_differentiable_in);
  } else if (const auto* cubic = std::get_if<CubicOscillator>(&a)) {
    REQUIRE(cubic->value == std::get<CubicOscillator>(b).value);
    REQUIRE(cubic->dp == std::get<CubicOscillator>(b).dp);
  } else if (const auto* hertz = std::get_if<HertzContact>(&a)) {
    REQUIRE(hertz->value == std::get<HertzContact>(b).value);
    REQUIRE(hertz->dp == std::get<HertzContact>(b).dp);
  }
}

}  // namespace

TEST_CASE("built-in oscillators as text have the same fields, guards, resets and derivatives") {
  Random random(5);
  double worst = 0.0;
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      const HybridSystem given = hand_written_oscillator(kind, law);
      const HybridSystem read = equations::make_system(oscillator_text(kind, law)).system;
      INFO(given.name);
      REQUIRE(read.name == given.name);
      REQUIRE(read.parameters.size() == given.parameters.size());
      for (std::size_t i = 0; i < given.parameters.size(); ++i) {
        const ParameterInfo &a = given.parameters[i], &b = read.parameters[i];
        REQUIRE(b.name == a.name);
        REQUIRE(b.default_value == a.default_value);
        REQUIRE(range_text(b) == range_text(a));
        REQUIRE(b.meaning == a.meaning);
      }
      REQUIRE(read.forcing_frequency == given.forcing_frequency);
      const bool hard = law.name == "newton";  // the held mode is not in the text
      REQUIRE(read.modes.size() == (hard ? 1 : 2));
      REQUIRE(read.events.size() == (hard ? 1 : 2));
      for (int trial = 0; trial < 50; ++trial) {
        const Vector p = draw(given, random);
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
          REQUIRE(a.structure);
          REQUIRE(b.structure);
          require_equal(a.structure(p), b.structure(p));
        }
        for (std::size_t e = 0; e < read.events.size(); ++e) {
          const Event &a = given.events[e], &b = read.events[e];
          REQUIRE(b.name == a.name);
          REQUIRE(b.kind == a.kind);
          REQUIRE(b.from == a.from);
          REQUIRE(b.to == a.to);
          REQUIRE(b.continuous == a.continuous);
          REQUIRE(b.guard.level.has_value());
          REQUIRE(b.guard.level->coordinate == a.guard.level->coordinate);
          REQUIRE(b.guard.level->level == a.guard.level->level);
          REQUIRE(b.guard.level->sign == a.guard.level->sign);
          REQUIRE(b.guard.value(t, x, p) == a.guard.value(t, x, p));
          REQUIRE(b.reset.rebound.has_value() == a.reset.rebound.has_value());
          REQUIRE(static_cast<bool>(b.reset.map) == static_cast<bool>(a.reset.map));
          if (a.reset.map) {
            REQUIRE(evaluate(a.reset.map, t, x, p, n) == evaluate(b.reset.map, t, x, p, n));
            REQUIRE(evaluate(a.reset.dx, t, x, p, n) == evaluate(b.reset.dx, t, x, p, n));
            REQUIRE(evaluate(a.reset.dp, t, x, p, np) == evaluate(b.reset.dp, t, x, p, np));
            REQUIRE(b.log_volume_change(p) == a.log_volume_change(p));
          }
        }
        // The mode of a state, also on the barrier (the built-in systems without the held mass).
        for (const Vector& at : {x, vector({r, 0.7}), vector({r, -0.7}), vector({r, 0.0}), vector({r + 1e-13, 0.2})}) {
          const bool held = hard && at[0] == r && at[1] == 0.0;
          if (!held) REQUIRE(mode_at(read, t, at, p) == mode_at(given, t, at, p));
        }
      }
    }
  }
  INFO("largest difference " << worst);
  REQUIRE(worst < 1e-15);
}

TEST_CASE("built-in oscillators as text run on the same flows and lanes with identical bits") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      const HybridSystem given = hand_written_oscillator(kind, law);
      const HybridSystem read = equations::make_system(oscillator_text(kind, law)).system;
      INFO(given.name);
      const Vector p = parameters(given, {{"xi", 1.2}, {"eta", 0.8}, {"r", 0.7}});
      REQUIRE(lanes::lanes_support(read, p));
      for (std::size_t m = 0; m < read.modes.size(); ++m)
        REQUIRE(std::string(make_flow(read, m, p, {}).kind()) == make_flow(given, m, p, {}).kind());
      Propagator first(given, p, all_parameters(given)), second(read, p, all_parameters(read));
      Transition a, b;
      const Vector x0 = vector({0.1, 0.6});
      carry(first, 0.0, 3.0 * forcing_period(given, p), x0, {}, a);
      carry(second, 0.0, 3.0 * forcing_period(read, p), x0, {}, b);
      REQUIRE(a.event_sequence.size() > 2);
      REQUIRE(a.event_sequence == b.event_sequence);
      REQUIRE(a.x1 == b.x1);
      REQUIRE(a.Phi == b.Phi);
      REQUIRE(a.Psi == b.Psi);
    }
  }
}

TEST_CASE("Hertz contact without damping and a linear spring without beta keep their fast flows") {
  SystemWriter writer;
  writer.system.name = "plain";
  writer.states({"x", "v"}).forcing("w");
  writer.parameter("w", "0.8").parameter("F", "1").parameter("r", "0.7").parameter("k", "100");
  writer.mode("free", "x' = v; v' = F*cos(t*w) - x");
  writer.mode("contact", "x' = v\nv' = F*cos(w*t) - x\n  - k*sqrt(x - r)^3");
  writer.event({"enter", "enter", "x - r", "", "free", "contact"});
  writer.event({"leave", "leave", "-x + r", "", "contact", "free"});
  const HybridSystem read = equations::make_system(writer.system).system;
  const Vector p = default_parameters(read.parameters);
  REQUIRE(std::string(make_flow(read, 0, p, {}).kind()) == "closed form");
  REQUIRE(std::string(make_flow(read, 1, p, {}).kind()) == "regularised Hertz contact");
  REQUIRE(read.events[0].continuous);
  REQUIRE_THAT(check_transition(read, p, 0.0, 10.0, vector({0.1, 0.6}), 1e-6, 2e-5), all_agree());
}

TEST_CASE("Duffing between two stops as text: motion, derivatives through impacts of both stops, tied parameters, outputs") {
  const equations::TextSystem read = equations::make_system(duffing_text());
  const HybridSystem& system = read.system;
  REQUIRE(system.parameters.size() == 6);
  REQUIRE(system.parameters[3].default_value == 0.5);
  REQUIRE(read.tied.size() == 1);
  const Vector p = default_parameters(system.parameters);
  REQUIRE(read.tied[0].value(p) == Approx(0.6 * 0.64).epsilon(1e-15));
  Vector gradient(p.size());
  read.tied[0].dp(p, gradient);
  REQUIRE((gradient - vector({0.0, 0.64, 2.0 * 0.6 * 0.8, 0.0, 0.0, 0.0})).norm() < 1e-15);
  REQUIRE(system.events[0].reset.rebound.has_value());
  REQUIRE(system.events[0].guard.level.has_value());
  // The stop at -r is no level given by a parameter alone; its reset sets x there exactly.
  REQUIRE(!system.events[1].guard.level.has_value());
  Vector after(2);
  system.events[1].reset.map(0.0, vector({-0.6000001, -1.0}), p, after);
  REQUIRE(after == vector({-0.6, 0.8}));
  REQUIRE_THAT(check_mode(system, 0, 0.4, vector({0.2, -0.3}), p), all_agree());
  for (const std::size_t event : {0, 1}) REQUIRE_THAT(check_event(system, event, 0.4, vector({0.2, -0.3}), p), all_agree());

  const Vector q = parameters(system, {{"A", 2.2}});
  const double T = forcing_period(system, q);
  const Trajectory run = simulate(system, q, 0.0, *read.start, {.t_end = 4.0 * T});
  int struck[2] = {0, 0};
  for (const EventRecord& event : run.events) ++struck[event.event];
  REQUIRE(struck[0] > 2);
  REQUIRE(struck[1] > 2);
  REQUIRE_THAT(check_transition(system, q, 0.0, 2.0 * T, *read.start, 1e-7, 1e-5), all_agree());
  // Liouville: -2 b per unit of time and 2 ln k_r per impact.
  Propagator propagator(system, q);
  Transition transition;
  carry(propagator, 0.0, 2.0 * T, *read.start, {}, transition);
  REQUIRE(std::abs(transition.log_det - transition.liouville) < 1e-11);

  // The rate of the energy is the power of forcing and damping.
  const Vector x = vector({0.2, -0.3});
  const double t = 0.7, force = p[1] * 0.64 * std::cos(0.8 * t) - 2.0 * p[0] * x[1];
  REQUIRE(read.outputs[0].value(0, t, x, p) == Approx(0.045 + 0.02 + 0.5 * 0.0016 / 4).epsilon(1e-14));
  REQUIRE(read.outputs[1].value(0, t, x, p) == Approx(x[1] * force).epsilon(1e-12));
}
