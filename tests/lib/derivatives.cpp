// SPDX-License-Identifier: GPL-3.0-or-later
// The linearised map along a motion through any number of events: Phi, and Psi in every parameter, against differences of the
// motion itself; Liouville's identity; the factors.
#include "support/checks.hpp"

#include <graze/lib/models/oscillator.hpp>

using namespace graze;
using namespace graze::support;

namespace {

Vector draw(const HybridSystem& system, Random& random) {
  Vector p = parameters(system,
                        {{"b", random(0.02, 0.4)}, {"xi", random(0.5, 1.5)}, {"eta", random(0.4, 0.9)}, {"r", random(0.0, 0.8)}});
  for (std::size_t i = oscillator_parameter::law; i < system.parameters.size(); ++i) {
    const std::string& name = system.parameters[i].name;
    p[static_cast<Eigen::Index>(i)] = name == "k_H"   ? random(20.0, 150.0)
                                      : name == "b_H" ? random(0.02, 0.3)
                                      : name == "k_S" ? random(2.0, 50.0)
                                                      : random(0.4, 0.95);
  }
  return p;
}

/// A random run with events, none of them slow. Near grazing the differences themselves are inaccurate.
struct Run {
  Vector p, x0;
  double t0 = 0.0, t1 = 0.0;
};

Run draw_run(const HybridSystem& system, Random& random, double periods) {
  for (;;) {
    Run run{draw(system, random), {}, random(0.0, 4.0), 0.0};
    run.x0 = vector({run.p[oscillator_parameter::r] - random(0.1, 1.0), random(-1.0, 2.0)});
    run.t1 = run.t0 + periods * forcing_period(system, run.p);
    const Trajectory motion = simulate(system, run.p, run.t0, run.x0, {.t_end = run.t1, .max_events = 40});
    bool good = motion.termination == Termination::time && !motion.events.empty();
    for (const EventRecord& event : motion.events) good = good && event.normal_speed > 0.25 && event.kind != EventKind::stick;
    if (good) return run;
  }
}

}  // namespace

TEST_CASE("Phi and Psi in every parameter agree with differences through several events for all laws") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      const HybridSystem system = make_oscillator(kind, law);
      Random random(8);
      for (int i = 0; i < 12; ++i) {
        const Run run = draw_run(system, random, i % 3 == 0 ? 2.0 : 1.0);
        for (const FlowKind flow : {FlowKind::automatic, FlowKind::general}) {
          // Steps of 2e-5: the motion is accurate to 1e-13, which gives 1e-13/2e-5 = 5e-9. The contact's sqrt makes the
          // differences converge slowly, so that smaller errors cannot be resolved.
          INFO(system.name << ", run " << i);
          REQUIRE_THAT(check_transition(system, run.p, run.t0, run.t1, run.x0, 1e-7, 2e-5, {.kind = flow}), all_agree());
        }
      }
    }
  }
}

TEST_CASE("the derivative in one active parameter is the column of the derivative in all") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      const HybridSystem system = make_oscillator(kind, law);
      Random random(9);
      const Run run = draw_run(system, random, 1.0);
      const TransitionOptions options{.sensitivity = Sensitivity::state_and_parameters};
      Propagator all(system, run.p, all_parameters(system));
      Transition together, alone, none;
      carry(all, run.t0, run.t1, run.x0, options, together);
      for (std::size_t k = 0; k < system.parameters.size(); ++k) {
        Propagator single(system, run.p, {k});
        carry(single, run.t0, run.t1, run.x0, options, alone);
        INFO(system.name << ", " << system.parameters[k].name);
        REQUIRE(alone.Psi.cols() == 1);
        // Not to rounding: the step sizes differ, and for beta the kind of flow.
        REQUIRE((alone.Psi.col(0) - together.Psi.col(static_cast<Eigen::Index>(k))).norm() < 1e-10 * (1.0 + together.Psi.norm()));
        REQUIRE((alone.Phi - together.Phi).norm() < 1e-10 * (1.0 + together.Phi.norm()));
      }
      carry(all, run.t0, run.t1, run.x0, {.sensitivity = Sensitivity::state}, alone);
      carry(all, run.t0, run.t1, run.x0, {.sensitivity = Sensitivity::none}, none);
      REQUIRE(alone.Psi.cols() == 0);
      REQUIRE((alone.Phi - together.Phi).norm() < 1e-10 * (1.0 + together.Phi.norm()));
      REQUIRE((alone.x1 - together.x1).norm() < 1e-11);
      REQUIRE((none.x1 - together.x1).norm() < 1e-11);
    }
  }
}

TEST_CASE("Liouville: the sum of ln det of the factors equals that of divergences and impacts to 1e-12 for all laws") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      const HybridSystem system = make_oscillator(kind, law);
      Random random(10);
      for (int i = 0; i < 12; ++i) {
        const Run run = draw_run(system, random, 1.0);
        Propagator propagator(system, run.p);
        Transition transition;
        carry(propagator, run.t0, run.t1, run.x0, {.keep_factors = true, .keep_events = true}, transition);
        INFO(system.name << ", run " << i);
        REQUIRE(transition.termination == Termination::time);
        REQUIRE(std::abs(transition.log_det - transition.liouville) < 1e-12 * (1.0 + std::abs(transition.liouville)));
        // The exact value where it is known: -2 b (t1 - t0) + 2 p ln k_r.
        const double damping = -2.0 * run.p[oscillator_parameter::b] * (run.t1 - run.t0);
        if (law.name == "linear") REQUIRE(std::abs(transition.liouville - damping) < 1e-12);
        if (law.name == "newton")
          REQUIRE(std::abs(transition.liouville - damping -
                           2.0 * static_cast<double>(transition.events.size()) * std::log(run.p[oscillator_parameter::law])) <
                  1e-12);
        Matrix product = Matrix::Identity(2, 2);
        for (const Matrix& factor : transition.factors) product = factor * product;
        REQUIRE((product - transition.Phi).norm() < 1e-14 * (1.0 + product.norm()));
      }
    }
  }
}

TEST_CASE("the divergence of damped Hertz contact is the integral of the contact damping") {
  // -2 b dt - integral of k_H y^3 b_H dt; Simpson's rule over sampled depths gives the integral.
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b_H", 0.2}, {"r", 0.5}});
  Flow flow = make_flow(system, 1, p, {});
  Segment whole, part;
  flow.carry({0.3, 50.0, Sensitivity::state}, vector({0.5, 1.2}), whole);
  REQUIRE(whole.end == FlowEnd::event);
  const int n = 2000;
  const double h = (whole.t1 - whole.t0) / n;
  double sum = 0.0;
  for (int i = 1; i < n; ++i) {
    flow.carry({0.3, 0.3 + i * h, Sensitivity::none}, vector({0.5, 1.2}), part);
    sum += (i % 2 == 1 ? 4.0 : 2.0) * std::pow(part.x1[0] - 0.5, 1.5);
  }
  const double expected = -2.0 * p[0] * (whole.t1 - whole.t0) - p[5] * p[6] * sum * h / 3.0;
  REQUIRE(whole.divergence == Approx(expected).epsilon(1e-6));  // the integrand begins and ends as t^(3/2)
  REQUIRE(std::log(whole.Phi.determinant()) == Approx(whole.divergence).margin(1e-12));
}

TEST_CASE("a transition reports its events, sequence, modes and termination") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"r", 0.3}, {"eta", 0.8}});
  Propagator propagator(system, p);
  Transition transition;
  const double T = forcing_period(system, p);
  carry(propagator, 0.0, T, vector({0.0, 1.0}), {.keep_events = true}, transition);
  REQUIRE(transition.termination == Termination::time);
  REQUIRE(transition.mode0 == 0);
  REQUIRE(transition.events.size() == transition.event_sequence.size());
  REQUIRE(transition.events.size() >= 2);
  const Trajectory run = simulate(system, p, 0.0, vector({0.0, 1.0}), {.t_end = T});
  REQUIRE(run.events.size() == transition.events.size());
  REQUIRE((run.x - transition.x1).norm() < 1e-12);
  REQUIRE(run.mode == transition.mode1);
  carry(propagator, 0.0, T, vector({0.0, 1.0}), {.max_events = 1}, transition);
  REQUIRE(transition.termination == Termination::event_limit);
  REQUIRE(transition.event_sequence.size() == 1);
  REQUIRE(transition.events.empty());
  const HybridSystem hard = make_oscillator("linear", "newton");
  Propagator other(hard, default_parameters(hard.parameters));
  carry(other, 0.0, 1.0, vector({2.5, 0.0}), {}, transition);
  REQUIRE(transition.termination == Termination::inadmissible_start);
  carry(other, 0.0, 1.0, vector({std::nan(""), 0.0}), {}, transition);
  REQUIRE(transition.termination == Termination::inadmissible_start);
  REQUIRE_THROWS_WITH(carry(other, 0.0, 1.0, Vector::Zero(3), {}, transition),
                      "the state has 3 entries; system linear-newton has 2");
}
