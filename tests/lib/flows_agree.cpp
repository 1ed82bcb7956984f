// SPDX-License-Identifier: GPL-3.0-or-later
// Where two flows apply, they agree within 1e-11 over a forcing period. The closed form, the series and the regularised
// contact are compared with the general integrator in the state, Phi and Psi (every parameter in which both can
// differentiate). The random starts have parameter values beyond the published ones, including undamped, critical and
// overdamped systems.
#include "support/checks.hpp"

#include <graze/lib/models/oscillator.hpp>

#include <string>

using namespace graze;
using namespace graze::support;

namespace {

/// Random parameters; b is given.
Vector draw(const HybridSystem& system, double b, Random& random) {
  Vector p = parameters(system, {{"b", b}, {"xi", random(0.4, 1.6)}, {"eta", random(0.3, 0.9)}, {"r", random(-0.3, 0.9)}});
  for (std::size_t i = oscillator_parameter::law; i < system.parameters.size(); ++i) {
    const std::string& name = system.parameters[i].name;
    p[static_cast<Eigen::Index>(i)] = name == "k_H"   ? random(20.0, 200.0)
                                      : name == "b_H" ? random(0.0, 0.3)
                                      : name == "k_S" ? random(2.0, 60.0)
                                                      : random(0.3, 1.0);
  }
  return p;
}

bool has_two_flows(const HybridSystem& system) {
  const Vector p = default_parameters(system.parameters);
  for (std::size_t mode = 0; mode < system.modes.size(); ++mode)
    if (std::string(make_flow(system, mode, p, {}).kind()) != "general") return true;
  return false;
}

/// Largest entry of a - b relative to 1 + the largest of a.
double distance(const Matrix& a, const Matrix& b) {
  return a.size() == 0 ? 0.0 : (a - b).cwiseAbs().maxCoeff() / (1.0 + a.cwiseAbs().maxCoeff());
}

struct Comparison {
  int runs = 0, contacts = 0;
  double state = 0.0, Phi = 0.0, Psi = 0.0;
};

/// One period from random starts with both kinds of flow. Runs with an impact slower than 0.05 are skipped: such an impact
/// multiplies every error by 1/speed, so that no accuracy over the period can be guaranteed.
Comparison compare_flows(const OscillatorKind& kind, const ContactLaw& law, double b, int runs, unsigned seed) {
  const HybridSystem system = make_oscillator(kind, law);
  std::vector<std::size_t> active = all_parameters(system);
  // The closed form has no derivative in beta.
  if (kind.beta == 0.0) active.erase(active.begin() + oscillator_parameter::beta);
  Random random(seed);
  Comparison worst;
  while (worst.runs < runs) {
    const Vector p = draw(system, b, random);
    const double t0 = random(-5.0, 20.0), T = forcing_period(system, p);
    const Vector x0 = vector({p[oscillator_parameter::r] - random(0.0, 1.0), random(-1.0, 2.0)});
    Propagator fast(system, p, active), general(system, p, active, {.kind = FlowKind::general});
    const TransitionOptions options{.sensitivity = Sensitivity::state_and_parameters, .keep_events = true};
    Transition one, other;
    carry(fast, t0, t0 + T, x0, options, one);
    REQUIRE(one.termination == Termination::time);
    bool slow = false;
    for (const EventRecord& event : one.events) slow = slow || event.normal_speed < 0.05;
    if (slow) continue;
    carry(general, t0, t0 + T, x0, options, other);
    REQUIRE(other.termination == Termination::time);
    REQUIRE(one.event_sequence == other.event_sequence);
    ++worst.runs;
    worst.contacts += static_cast<int>(one.events.size());
    worst.state = std::max(worst.state, distance(one.x1, other.x1));
    worst.Phi = std::max(worst.Phi, distance(one.Phi, other.Phi));
    worst.Psi = std::max(worst.Psi, distance(one.Psi, other.Psi));
  }
  return worst;
}

}  // namespace

TEST_CASE("where two flows apply state and Phi and Psi agree within 1e-11 over a period for all laws and any damping") {
  unsigned seed = 1;
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      if (!has_two_flows(make_oscillator(kind, law))) continue;
      // Each flow has an error of some 1e-13 per contact, amplified by the motion. A defect of either stands out at 1e-11.
      for (const double b : {0.0, 0.05, 0.4, 1.0, 1.6}) {
        const Comparison worst = compare_flows(kind, law, b, 60, seed++);
        INFO(kind.name << ", " << law.name << ", b = " << b << ": state " << worst.state << ", Phi " << worst.Phi << ", Psi "
                       << worst.Psi);
        CHECK(worst.contacts > 20);
        CHECK(worst.state < 1e-11);
        CHECK(worst.Phi < 1e-11);
        CHECK(worst.Psi < 1e-11);
      }
    }
  }
}

TEST_CASE("the flows agree on the published systems over ten periods of chaos") {
  // eta = 0.711: the exponent is below 0.02 per unit of time, so that an error grows by at most exp(0.02 * 90) = 6.
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"eta", 0.711}, {"b_H", 0.1}});
  const double T = forcing_period(system, p);
  const Trajectory fast = simulate(system, p, 0.0, vector({1.5, 0.5}), {.t_end = 10 * T});
  const Trajectory general = simulate(system, p, 0.0, vector({1.5, 0.5}), {.t_end = 10 * T}, {.kind = FlowKind::general});
  REQUIRE(fast.events.size() == general.events.size());
  REQUIRE(fast.events.size() >= 4);
  for (std::size_t i = 0; i < fast.events.size(); ++i) {
    REQUIRE(fast.events[i].kind == general.events[i].kind);
    REQUIRE(fast.events[i].t == Approx(general.events[i].t).margin(1e-11));
    REQUIRE(fast.events[i].normal_speed == Approx(general.events[i].normal_speed).margin(1e-10));
  }
  REQUIRE((fast.x - general.x).norm() < 1e-10);
}
