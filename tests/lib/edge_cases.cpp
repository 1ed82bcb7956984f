// SPDX-License-Identifier: GPL-3.0-or-later
// Starts, ends and coincidences that lie exactly on a guard. Each case runs for every law on every oscillator, with the fast
// flows and with the general one.
#include "support/checks.hpp"
#include "support/two_mass_oscillator.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/trajectory.hpp>

#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

using std::numbers::pi;

/// Calls `test(system, law, options)` for every law on every oscillator with both kinds of flow.
template <class Test> void for_each_system(const Test& test) {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      for (const FlowKind flow : {FlowKind::automatic, FlowKind::general}) {
        const HybridSystem system = make_oscillator(kind, law);
        INFO(system.name << (flow == FlowKind::general ? ", general flow" : ", fast flows"));
        FlowOptions options;
        options.kind = flow;
        test(system, law, options);
      }
    }
  }
}

/// Parameters with the forcing amplitude that gives a mass at rest at the barrier, at forcing phase 0, the acceleration a.
Vector with_barrier_acceleration(const HybridSystem& system, double a, double r = 0.5) {
  Vector p = parameters(system, {{"r", r}, {"eta", 0.8}});
  p[oscillator_parameter::xi] = a + r + p[oscillator_parameter::beta] * r * r * r;
  return p;
}

}  // namespace

TEST_CASE("start on the barrier moving in") {
  for_each_system([](const HybridSystem& system, const ContactLaw& law, const FlowOptions& options) {
    Vector p = with_barrier_acceleration(system, -0.7);
    if (law.hard) p[oscillator_parameter::law] = 0.6;
    const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.3}), {.t_end = 0.5}, options);
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.events.size() == 1);  // impact at once, or exit after a short contact
    if (law.hard) {
      REQUIRE(run.events[0].t == 0.0);
      REQUIRE(run.events[0].normal_speed == 0.3);
      REQUIRE(run.events[0].exit_speed == 0.6 * 0.3);
      REQUIRE(run.events[0].x_plus == vector({0.5, -0.6 * 0.3}));
    } else {
      REQUIRE(run.segments[0].mode == 1);
      REQUIRE(run.events[0].kind == EventKind::leave);
      REQUIRE(run.events[0].t > 0.01);
    }
  });
}

TEST_CASE("start on the barrier moving out") {
  for_each_system([](const HybridSystem& system, const ContactLaw& law, const FlowOptions& options) {
    for (const double speed : {1e-2, 1e-4, 1e-7, 1e-11}) {
      for (const double a : {-0.7, 0.7}) {
        INFO("speed " << speed << ", acceleration " << a);
        Vector p = with_barrier_acceleration(system, a);
        if (law.hard) p[oscillator_parameter::law] = 1.0;
        // Pulled away: no event. Pressed: the mass returns after 2 speed/a, and not before half of that time.
        const double t_end = a < 0.0 ? 0.1 : 3.0 * speed / a;
        const Trajectory run = simulate(system, p, 0.0, vector({0.5, -speed}), {.t_end = t_end, .max_events = 1}, options);
        REQUIRE(run.segments[0].mode == 0);
        if (a < 0.0) {
          REQUIRE(run.events.empty());
        } else {
          REQUIRE(run.events.size() == 1);
          REQUIRE(run.events[0].t > speed / a);
          // To first order the time is 2 speed/a. The relative error is of the size of the speed.
          REQUIRE(run.events[0].t == Approx(2.0 * speed / a).epsilon(2.0 * speed + 1e-9));
          REQUIRE(run.events[0].normal_speed == Approx(speed).epsilon(2.0 * speed + 1e-9));
        }
      }
    }
  });
}

TEST_CASE("start on the barrier at rest, pressed against it") {
  for_each_system([](const HybridSystem& system, const ContactLaw& law, const FlowOptions& options) {
    const Vector p = with_barrier_acceleration(system, 0.7);
    const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.0}), {.t_end = 0.2}, options);
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.events.empty());
    REQUIRE(run.mode == 1);  // in contact, or held
    if (law.hard) {
      REQUIRE(run.x == vector({0.5, 0.0}));
    } else {
      REQUIRE(run.x[0] > 0.5);  // the soft stop yields
      REQUIRE(run.x[0] < 0.5 + 0.5 * 0.7 * 0.04);
    }
  });
}

TEST_CASE("start on the barrier at rest, pulled away from it") {
  for_each_system([](const HybridSystem& system, const ContactLaw&, const FlowOptions& options) {
    const Vector p = with_barrier_acceleration(system, -0.7);
    const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.0}), {.t_end = 0.2}, options);
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.events.empty());
    REQUIRE(run.mode == 0);
    // r + a t^2 / 2. Damping and the change of the forcing enter with t^3, here less than 5e-4.
    REQUIRE(run.x[0] == Approx(0.5 - 0.5 * 0.7 * 0.04).epsilon(1e-3));
  });
}

TEST_CASE("start on the barrier at rest up to rounding: the run continues") {
  // With a speed of the size of rounding in either direction, enter and leave, or impact and impact, must not alternate
  // forever.
  for_each_system([](const HybridSystem& system, const ContactLaw&, const FlowOptions& options) {
    for (const double speed : {1e-17, -1e-17, 3e-16, -3e-16, 1e-14, -1e-14}) {
      for (const double a : {0.7, 1e-9, 0.0, -1e-9, -0.7}) {
        INFO("speed " << speed << ", acceleration " << a);
        const Vector p = with_barrier_acceleration(system, a);
        const Trajectory run = simulate(system, p, 0.0, vector({0.5, speed}), {.t_end = 0.2, .max_events = 200}, options);
        REQUIRE(run.termination == Termination::time);
        REQUIRE(run.events.size() < 20);
      }
    }
  });
}

TEST_CASE("start on the barrier at rest without acceleration: the next derivative decides") {
  // At the phase where xi cos(eta t) = r + beta r^3 the mass is in equilibrium at the barrier. The force then grows or falls.
  for_each_system([](const HybridSystem& system, const ContactLaw&, const FlowOptions& options) {
    Vector p = parameters(system, {{"r", 0.0}, {"eta", 1.0}, {"xi", 1.0}});
    for (const double phase : {pi / 2, -pi / 2, 3 * pi / 2}) {
      const bool grows = std::sin(phase) < 0.0;
      const Trajectory run = simulate(system, p, phase, vector({0.0, 0.0}), {.t_end = phase + 0.1, .max_events = 200}, options);
      INFO("force " << (grows ? "grows" : "falls"));
      REQUIRE(run.termination == Termination::time);
      REQUIRE(run.x.allFinite());
      REQUIRE(run.mode == (grows ? 1 : 0));
      REQUIRE(run.events.size() <= 2);
    }
  });
}

TEST_CASE("start in contact") {
  for_each_system([](const HybridSystem& system, const ContactLaw& law, const FlowOptions& options) {
    const Vector p = with_barrier_acceleration(system, -0.7);
    if (law.hard) {
      REQUIRE_THROWS_WITH(simulate(system, p, 0.0, vector({0.55, -0.3}), {.t_end = 1.0}, options),
                          "the state (0.55, -0.3) lies inside the barrier; start on the free side of it");
      return;
    }
    const Trajectory run = simulate(system, p, 0.0, vector({0.52, 0.1}), {.t_end = 1.0}, options);
    REQUIRE(run.segments[0].mode == 1);
    REQUIRE(run.events.size() == 1);
    REQUIRE(run.events[0].kind == EventKind::leave);
    REQUIRE(run.events[0].x_minus[0] == 0.5);
    REQUIRE(run.events[0].normal_speed > 0.0);
  });
}

TEST_CASE("event exactly at the end time") {
  for_each_system([](const HybridSystem& system, const ContactLaw&, const FlowOptions& options) {
    for (const double start : {-1.3, -0.4, 0.1, 0.2, 0.3}) {
      const Vector p = with_barrier_acceleration(system, -0.2);
      const Vector x0 = vector({start, 1.0});
      const Trajectory free_run = simulate(system, p, 0.0, x0, {.t_end = 20.0, .max_events = 3}, options);
      REQUIRE(free_run.events.size() >= 2);  // the third may be late
      for (std::size_t k = 0; k < free_run.events.size(); ++k) {
        const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = free_run.events[k].t}, options);
        INFO("event " << k);
        REQUIRE(run.termination == Termination::time);
        REQUIRE(run.t == free_run.events[k].t);
        REQUIRE(run.events.size() == k + 1);
        REQUIRE((run.x - free_run.events[k].x_plus).norm() < 1e-12);  // the event time is rounded, and so is the state
        // A run that continues from there does not meet the event again.
        const double later = free_run.events[k].t + 1e-3;
        REQUIRE(simulate(system, p, run.t, run.x, {.t_end = later}, options).events.empty());
      }
    }
  });
}

TEST_CASE("an end time equal to the start gives a run of zero length") {
  for_each_system([](const HybridSystem& system, const ContactLaw&, const FlowOptions& options) {
    const Trajectory run = simulate(system, parameters(system), 1.0, vector({0.1, 0.2}), {.t_end = 1.0}, options);
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.t == 1.0);
    REQUIRE(run.x == vector({0.1, 0.2}));
    REQUIRE(run.events.empty());
  });
}

TEST_CASE("two simultaneous events fire in the order of their declaration") {
  // Equal masses with equal starts and no forcing move as one. They reach their barriers at the same instant.
  HybridSystem system = two_mass_oscillator();
  const Vector p = parameters(system, {{"mu", 1.0}, {"xi", 0.0}, {"r1", 0.6}, {"r2", 0.6}, {"k_r", 0.7}});
  for (int i = 0; i < 40; ++i) {
    const double x = -1.0 + 0.03 * i, v = 1.3;
    for (const bool swapped : {false, true}) {
      if (swapped != (system.events[0].name == "impact-2")) std::swap(system.events[0], system.events[1]);
      const Trajectory run = simulate(system, p, 0.0, vector({x, v, x, v}), {.t_end = 30.0, .max_events = 2});
      INFO("start " << x);
      REQUIRE(run.events.size() == 2);
      REQUIRE(run.events[0].event == 0);
      REQUIRE(run.events[1].event == 1);
      REQUIRE(run.events[0].t == run.events[1].t);
      REQUIRE(run.events[1].normal_speed == Approx(run.events[0].normal_speed).epsilon(1e-12));
      REQUIRE(run.x[1] == Approx(run.x[3]).epsilon(1e-12));
      // In that order the saltation matrices compose to those of two events: both speeds are reversed.
      REQUIRE(run.x[1] < 0.0);
    }
  }
}

TEST_CASE("tangency from outside: a motion that touches the barrier and turns back does not fire") {
  for (const ContactLaw& law : contact_laws()) {
    const HybridSystem system = make_oscillator("linear", law.name);
    for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
      INFO(law.name << (kind == FlowKind::general ? ", general flow" : ""));
      FlowOptions options;
      options.kind = kind;
      // x = sin t, unforced and undamped. 1e-12 is twenty times the error of the general flow over the quarter turn.
      const auto run = [&](double r, double x, double v) {
        return simulate(system, parameters(system, {{"b", 0.0}, {"xi", 0.0}, {"r", r}}), 0.0, vector({x, v}), {.t_end = 3.0},
                        options);
      };
      if (kind == FlowKind::automatic) REQUIRE(run(1.0, 0.0, 1.0).events.empty());
      REQUIRE(run(1.0 + 1e-12, 0.0, 1.0).events.empty());
      REQUIRE(run(1.0 - 1e-12, 0.0, 1.0).events.size() == (law.hard ? 1 : 2));
      REQUIRE(run(1.0 + 1e-8, 0.0, 1.0).events.empty());
      REQUIRE(run(1.0 - 1e-8, 0.0, 1.0).events.size() == (law.hard ? 1 : 2));
    }
  }
}

TEST_CASE("tangency from inside: a contact that almost lifts off continues") {
  // Linear stop, unforced and undamped: about the equilibrium x_s = k_S r/(1 + k_S) the mass oscillates with amplitude A and
  // frequency q.
  const HybridSystem system = make_oscillator("linear", "linear");
  const double r = -1.0, k_S = 3.0, q = 2.0, x_s = k_S * r / (1.0 + k_S);
  const Vector p = parameters(system, {{"b", 0.0}, {"xi", 0.0}, {"r", r}, {"k_S", k_S}});
  for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
    FlowOptions options;
    options.kind = kind;
    for (const double short_of : {1e-12, 1e-8, 1e-4}) {
      // Least depth +short_of: the mass stays in contact. Least depth -short_of: it leaves and returns.
      REQUIRE(simulate(system, p, 0.0, vector({x_s, q * (x_s - r - short_of)}), {.t_end = 3.0}, options).events.empty());
      const Trajectory out = simulate(system, p, 0.0, vector({x_s, q * (x_s - r + short_of)}), {.t_end = 3.0}, options);
      REQUIRE(out.events.size() == 2);
      REQUIRE(out.events[0].kind == EventKind::leave);
      REQUIRE(out.events[1].kind == EventKind::enter);
    }
  }
}

TEST_CASE("re-trigger after the reset: an impact does not fire again as the mass leaves at any speed") {
  for_each_system([](const HybridSystem& system, const ContactLaw& law, const FlowOptions& options) {
    for (const double speed : {1e-2, 1e-5, 1e-8, 1e-11}) {
      Vector p = with_barrier_acceleration(system, -0.7);
      if (law.hard) p[oscillator_parameter::law] = 0.8;
      const Trajectory run = simulate(system, p, 0.0, vector({0.5, speed}), {.t_end = 0.3}, options);
      INFO("speed " << speed);
      REQUIRE(run.termination == Termination::time);
      REQUIRE(run.events.size() == 1);
      REQUIRE(run.x[1] < 0.0);
    }
  });
}

TEST_CASE("re-trigger after the reset: a reset that makes another guard active fires it at the same instant") {
  // The reset of the first mass's impact transfers its speed to the second mass, which rests at its own barrier.
  HybridSystem system = two_mass_oscillator();
  const Vector p = parameters(system, {{"xi", 0.0}, {"r1", 0.6}, {"r2", 0.0}, {"k_r", 0.5}, {"kappa", 0.0}});
  system.events[0].reset.map = [](double, const Vector& x, const Vector&, Vector& out) { out << 0.6, -0.1, 0.0, x[1]; };
  for (const bool swapped : {false, true}) {
    if (swapped) std::swap(system.events[0], system.events[1]);
    const Trajectory run = simulate(system, p, 0.0, vector({0.0, 1.0, 0.0, 0.0}), {.t_end = 1.0}, {});
    REQUIRE(run.events.size() == 2);
    REQUIRE(system.events[run.events[0].event].name == "impact-1");
    REQUIRE(system.events[run.events[1].event].name == "impact-2");
    REQUIRE(run.events[1].t == run.events[0].t);
    REQUIRE(run.events[1].normal_speed == run.events[0].normal_speed);
  }
}

TEST_CASE("a run entirely in contact meets no event") {
  for (const OscillatorKind& kind : oscillator_kinds()) {
    for (const ContactLaw& law : contact_laws()) {
      if (law.hard) continue;
      const HybridSystem system = make_oscillator(kind, law);
      // Preloaded: the barrier lies at r = -1, and the forcing is too weak to lift the mass off.
      const Vector p = parameters(system, {{"r", -1.0}, {"xi", 0.3}, {"eta", 0.9}});
      const Trajectory run = simulate(system, p, 0.0, vector({-0.95, 0.0}), {.t_end = 60.0});
      INFO(system.name);
      REQUIRE(run.termination == Termination::time);
      REQUIRE(run.events.empty());
      REQUIRE(run.segments.size() == 1);
      REQUIRE(run.mode == 1);
      const Trajectory general = simulate(system, p, 0.0, vector({-0.95, 0.0}), {.t_end = 60.0}, {.kind = FlowKind::general});
      REQUIRE(general.events.empty());
      REQUIRE((run.x - general.x).norm() < 1e-11);
    }
  }
}
