// SPDX-License-Identifier: GPL-3.0-or-later
// Chattering: infinitely many impacts in finite time, then sticking and release.
#include "support/bouncing_ball.hpp"
#include "support/checks.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/trajectory.hpp>

using namespace graze;
using namespace graze::support;

namespace {

using Long = long double;

/// Start at phase 0, pressed against a barrier at r = 0.5 until cos(eta t) = r: long enough for a complete series of impacts.
Vector pressed(const HybridSystem& system, double k_r, double eta = 0.3) {
  return parameters(
      system, {{"r", 0.5}, {"eta", eta}, {"xi", 1.0 + 0.5 * 0.25 * default_parameters(system.parameters)[1]}, {"k_r", k_r}});
}

double release_time(const Vector& p) {
  const double r = p[oscillator_parameter::r], load = r + p[oscillator_parameter::beta] * r * r * r;
  return std::acos(load / p[oscillator_parameter::xi]) / p[oscillator_parameter::eta];
}

/// Accumulation time of the linear oscillator's impacts in long double. Start: (r, v) at t = 0, moving into the barrier. Every
/// flight has the closed form; Newton's method from 2 u/a finds its end, until flights are shorter than 1e-17. `impacts`
/// returns the number of impacts.
Long accumulation_time(const Vector& p, Long v, int& impacts) {
  const Long b = p[0], xi = p[2], w = p[3], r = p[4], k_r = p[5];
  const Long D = (1 - w * w) * (1 - w * w) + 4 * b * b * w * w, C = xi * (1 - w * w) / D, S = xi * 2 * b * w / D;
  const Long q = std::sqrt(1 - b * b);
  Long t = 0;
  for (impacts = 1; impacts < 10000; ++impacts) {
    const Long u = k_r * v;  // departs with -u
    const Long a = xi * std::cos(w * t) + 2 * b * u - r, j = -xi * w * std::sin(w * t) - 2 * b * a + u;
    REQUIRE(a > 0);  // still pressed: the series is complete
    Long s = 2 * u / a;
    if (s < 1e-17L) return t + s / (1 - k_r);
    if (s > 1e-4L) {  // closed form; it cancels in shorter flights, which use their series
      const Long d = r - C * std::cos(w * t) - S * std::sin(w * t), e = -u - w * (S * std::cos(w * t) - C * std::sin(w * t));
      for (int i = 0; i < 60; ++i) {
        const Long decay = std::exp(-b * s), c = std::cos(q * s), n = std::sin(q * s) / q, at = w * (t + s);
        const Long x = C * std::cos(at) + S * std::sin(at) + decay * ((c + b * n) * d + n * e);
        v = w * (S * std::cos(at) - C * std::sin(at)) + decay * (-n * d + (c - b * n) * e);
        const Long move = (r - x) / v;
        s += move;
        if (std::abs(move) < 1e-19L) break;
      }
    } else {
      for (int i = 0; i < 20; ++i) s = 2 * u / (a + j * s / 3);  // 0 = -u + a s/2 + j s^2/6; next terms: s^3 u
      v = -u + a * s + j * s * s / 2;
    }
    t += s;
  }
  return t;
}

template <class Test> void for_both_flows(const Test& test) {
  for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
    INFO((kind == FlowKind::general ? "general flow" : "fast flows"));
    FlowOptions options;
    options.kind = kind;
    test(options);
  }
}

}  // namespace

TEST_CASE("a bouncing ball comes to rest at the sum of its geometric series") {
  const HybridSystem system = bouncing_ball();
  for (const double k_r : {0.05, 0.3, 0.6, 0.8, 0.95, 0.99}) {
    const Vector p = parameters(system, {{"k_r", k_r}});
    const double H = 1.7, g = 9.81;
    const Trajectory run = simulate(system, p, 0.0, vector({H, 0.0}), {.t_end = 200.0});
    INFO("k_r " << k_r);
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.events.back().kind == EventKind::stick);
    REQUIRE(run.mode == 1);
    REQUIRE(run.x == vector({0.0, 0.0}));
    // Under a constant force the series is geometric to the end. The only error is the rounding of each impact time.
    const double exact = std::sqrt(2.0 * H / g) * (1.0 + k_r) / (1.0 - k_r);
    REQUIRE(run.events.back().t == Approx(exact).epsilon(1e-15 * static_cast<double>(run.events.size() + 4)));
    for (std::size_t i = 0; i + 1 < run.events.size(); ++i) REQUIRE(run.events[i].kind == EventKind::impact);
  }
}

TEST_CASE("the accumulation time of an oscillator agrees with a long double iteration") {
  const HybridSystem system = make_oscillator("linear", "newton");
  for_both_flows([&](const FlowOptions& options) {
    for (const double k_r : {0.1, 0.4, 0.6, 0.8}) {
      for (const double v : {0.03, 0.1}) {
        const Vector p = pressed(system, k_r);
        int impacts = 0;
        const double exact = static_cast<double>(accumulation_time(p, v, impacts));
        const Trajectory run = simulate(system, p, 0.0, vector({0.5, v}), {.t_end = release_time(p)}, options);
        INFO("k_r " << k_r << ", speed " << v << ", accumulation at " << exact);
        REQUIRE(exact < 0.8 * release_time(p));
        const auto stick =
            std::find_if(run.events.begin(), run.events.end(), [](const EventRecord& e) { return e.kind == EventKind::stick; });
        REQUIRE(stick != run.events.end());
        // The series counts as complete when its remaining time is below 1e-6. The error is the square of that time, times the
        // relative change of the force, plus rounding.
        REQUIRE(std::abs(stick->t - exact) < 5e-12);
        REQUIRE(stick->x_plus == vector({0.5, 0.0}));
        REQUIRE(stick->exit_speed == 0.0);
        REQUIRE(static_cast<int>(run.events.size()) < impacts);
      }
    }
  });
}

TEST_CASE("the error from the accumulation window falls as its square and the impacts resolved grow as its logarithm") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const double k_r = 0.5;
  const Vector p = pressed(system, k_r);
  int impacts = 0;
  const double exact = static_cast<double>(accumulation_time(p, 0.3, impacts));
  std::size_t before = 0;
  for (const double window : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5}) {
    const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.3}), {.t_end = 3.0}, {.accumulation_window = window});
    const EventRecord& stick = run.events.back();
    REQUIRE(stick.kind == EventKind::stick);
    INFO("window " << window << ", error " << stick.t - exact);
    CHECK(std::abs(stick.t - exact) < window * window + 1e-14);
    // One more impact for each halving of the remaining time.
    if (before > 0) CHECK(std::abs(static_cast<double>(run.events.size() - before) - std::log(10.0) / -std::log(k_r)) <= 1.0);
    before = run.events.size();
  }
  // Without a window the series is carried to the resolution of time, and still ends.
  const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.3}), {.t_end = 3.0}, {.accumulation_window = 0.0});
  REQUIRE(run.events.back().kind == EventKind::stick);
  REQUIRE(std::abs(run.events.back().t - exact) < 1e-11);
  REQUIRE(run.events.size() < 60);
}

TEST_CASE("a sticking mass is held and released where the force changes sign") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    const HybridSystem system = make_oscillator(kind, contact_law("newton"));
    for_both_flows([&](const FlowOptions& options) {
      for (const double k_r : {0.0, 0.3, 0.7}) {
        const Vector p = pressed(system, k_r);
        const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.1}), {.t_end = release_time(p) + 0.5}, options);
        INFO(system.name << ", k_r " << k_r);
        const EventRecord& release = run.events.back();
        REQUIRE(release.kind == EventKind::release);
        REQUIRE(run.events[run.events.size() - 2].kind == EventKind::stick);
        REQUIRE(release.t == Approx(release_time(p)).epsilon(1e-14));
        REQUIRE(release.x_minus == vector({0.5, 0.0}));
        REQUIRE(release.x_plus == vector({0.5, 0.0}));
        REQUIRE(release.saltation.S.size() == 0);
        REQUIRE(run.mode == 0);
        // The mass leaves with the growing force: x - r = -xi eta sin(eta t) s^3/6 to first order.
        const double s = 0.5, expected = -p[2] * p[3] * std::sin(p[3] * release.t) * s * s * s / 6.0;
        REQUIRE(run.x[0] - 0.5 == Approx(expected).epsilon(0.1));
      }
    });
  }
}

TEST_CASE("a mass is held across the ends of forcing periods and forever if the force never releases it") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"r", -2.0}, {"k_r", 0.5}, {"eta", 0.7}});  // pressed at every phase
  const Trajectory run = simulate(system, p, 0.0, vector({-2.0, 0.3}), {.t_end = 100.0});
  REQUIRE(run.termination == Termination::time);
  REQUIRE(run.events.back().kind == EventKind::stick);
  REQUIRE(run.x == vector({-2.0, 0.0}));
  Propagator propagator(system, p);
  Transition transition;
  carry(propagator, 100.0, 200.0, run.x, {}, transition);
  REQUIRE(transition.termination == Termination::time);
  REQUIRE(transition.mode0 == 1);
  REQUIRE(transition.mode1 == 1);
  REQUIRE(transition.event_sequence.empty());
  REQUIRE(transition.x1 == vector({-2.0, 0.0}));
}

TEST_CASE("without restitution the first impact ends in sticking or in motion with the force") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = pressed(system, 0.0);
  const Trajectory run = simulate(system, p, 0.0, vector({0.0, 0.6}), {.t_end = 3.0});
  REQUIRE(run.events.size() == 1);
  REQUIRE(run.events[0].kind == EventKind::stick);
  REQUIRE(run.events[0].normal_speed > 0.1);
  REQUIRE(run.events[0].exit_speed == 0.0);
  // Pulled away: the mass has no speed at the barrier and follows the force.
  const Vector pulled = parameters(system, {{"r", 0.5}, {"xi", 0.2}, {"k_r", 0.0}, {"eta", 0.7}});
  const Trajectory away = simulate(system, pulled, 0.0, vector({0.4, 0.8}), {.t_end = 1.0});
  REQUIRE(away.events.size() == 1);
  REQUIRE(away.events[0].kind == EventKind::impact);
  REQUIRE(away.events[0].x_plus == vector({0.5, 0.0}));
  REQUIRE(away.mode == 0);
  REQUIRE(away.x[0] < 0.5);
}

TEST_CASE("after sticking the motion does not depend on its start: the factor and Phi are exactly zero") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    const HybridSystem system = make_oscillator(kind, contact_law("newton"));
    for (const double k_r : {0.0, 0.5}) {
      const Vector p = pressed(system, k_r);
      Propagator propagator(system, p, all_parameters(system));
      Transition transition;
      carry(propagator, 0.0, release_time(p) + 1.0, vector({0.4, 0.3}),
            {.sensitivity = Sensitivity::state_and_parameters, .keep_factors = true, .keep_events = true}, transition);
      INFO(system.name << ", k_r " << k_r);
      REQUIRE(transition.termination == Termination::time);
      REQUIRE(transition.Phi == Matrix::Zero(2, 2));
      REQUIRE(std::count(transition.factors.begin(), transition.factors.end(), Matrix(Matrix::Zero(2, 2))) == 1);
      REQUIRE(transition.log_det == -std::numeric_limits<double>::infinity());
      REQUIRE(transition.liouville == -std::numeric_limits<double>::infinity());
      // The dependence on the parameters remains, through the barrier, the time of release and the flight. It agrees with
      // differences.
      Vector inside = p;
      inside[oscillator_parameter::law] = 0.5;  // differences need room below k_r
      REQUIRE_THAT(check_transition(system, inside, 0.0, release_time(p) + 1.0, vector({0.4, 0.3}), 1e-8), all_agree());
    }
  }
}

TEST_CASE("a plastic impact without sticking leaves one multiplier exactly zero") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"r", 0.5}, {"xi", 0.2}, {"k_r", 0.0}, {"eta", 0.7}});
  Propagator propagator(system, p);
  Transition transition;
  carry(propagator, 0.0, 1.0, vector({0.4, 0.8}), {.keep_factors = true}, transition);
  REQUIRE(transition.termination == Termination::time);
  REQUIRE(transition.factors.size() == 3);
  REQUIRE(transition.factors[1].row(0).norm() == 0.0);
  REQUIRE(transition.factors[1].col(1).norm() == 0.0);
  REQUIRE(transition.factors[1](1, 0) != 0.0);
  REQUIRE(transition.log_det == -std::numeric_limits<double>::infinity());
}

TEST_CASE("a series of impacts that the force interrupts does not stick") {
  // The impacts begin so late that the force reverses before they accumulate.
  const HybridSystem system = make_oscillator("linear", "newton");
  for (const double k_r : {0.7, 0.9}) {
    const Vector p = pressed(system, k_r);
    const double start = release_time(p) - 0.15;
    const Trajectory run = simulate(system, p, start, vector({0.5, 0.02}), {.t_end = start + 1.0});
    INFO("k_r " << k_r);
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.events.size() >= 1);
    for (const EventRecord& event : run.events) REQUIRE(event.kind == EventKind::impact);
    REQUIRE(run.mode == 0);
    REQUIRE(run.x[0] < 0.5);
  }
}

TEST_CASE("a run that ends within a series of impacts ends at its end time") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = pressed(system, 0.6);
  int impacts = 0;
  const double exact = static_cast<double>(accumulation_time(p, 0.2, impacts));
  for (const double early : {1e-1, 1e-3, 1e-6, 5e-7, 1e-7, 1e-9, 1e-11, -1e-11, -1e-9, -1e-6}) {
    const double t_end = exact - early;
    const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.2}), {.t_end = t_end});
    INFO("ends " << early << " before the accumulation point");
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.t == t_end);
    if (early > 4e-11) REQUIRE(run.events.back().kind == EventKind::impact);
    if (early < -4e-11) REQUIRE(run.events.back().kind == EventKind::stick);
    for (const EventRecord& event : run.events) REQUIRE(event.t <= t_end);
  }
}

TEST_CASE("a run ends by time or by number of events and reports the reason") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = pressed(system, 0.6);
  const Trajectory by_number = simulate(system, p, 0.0, vector({0.5, 0.2}), {.t_end = 3.0, .max_events = 5});
  REQUIRE(by_number.termination == Termination::event_limit);
  REQUIRE(by_number.events.size() == 5);
  REQUIRE(by_number.t == by_number.events.back().t);
  REQUIRE(by_number.x == by_number.events.back().x_plus);
  REQUIRE_THAT(std::string(termination_text(by_number.termination)), Catch::StartsWith("the largest number of events"));
  const Trajectory by_time = simulate(system, p, 0.0, vector({0.5, 0.2}), {.t_end = 3.0});
  REQUIRE(by_time.termination == Termination::time);
  REQUIRE(by_time.t == 3.0);
  REQUIRE(termination_text(by_time.termination) == "the end time was reached");
}
