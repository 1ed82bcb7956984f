// SPDX-License-Identifier: GPL-3.0-or-later
// The general integrator: order of convergence in state and event time, its options, and guards that are hard to resolve.
#include "support/checks.hpp"
#include "support/extrapolation.hpp"
#include "support/two_sided_oscillator.hpp"

#include <graze/lib/flow/flow.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

using std::numbers::pi;

/// Free flight of the cantilever up to its barrier, in long double: time and speed of the impact.
struct Impact {
  double t, v;
};

Impact cantilever_impact(const Vector& p, double t0, const Vector& x0, double guess) {
  enum { b, beta, xi, eta, r };
  const auto field = [&](long double t, const LongState<2>& z, LongState<2>& dz) {
    dz[0] = z[1];
    dz[1] = p[xi] * std::cos(static_cast<long double>(p[eta]) * t) - 2.0L * p[b] * z[1] - z[0] - p[beta] * z[0] * z[0] * z[0];
  };
  long double t = guess;
  LongState<2> z = extrapolate<2>(field, t0, t, {x0[0], x0[1]});
  for (int i = 0; i < 20; ++i) {
    const long double move = (p[r] - z[0]) / z[1];
    if (std::abs(move) < 1e-18L) break;
    z = extrapolate<2>(field, t, t + move, z);
    t += move;
  }
  return {static_cast<double>(t), static_cast<double>(z[1])};
}

/// x' = 1, with guard h(x) given. The step control has nothing to resolve, so that each step has the largest allowed length.
HybridSystem clock_with_guard(double (*h)(double), double (*slope)(double)) {
  HybridSystem system;
  system.name = "clock";
  system.states = 1;
  Mode mode;
  mode.name = "running";
  mode.field = [](double, const Vector&, const Vector&, Vector& f) { f[0] = 1.0; };
  mode.field_dx = mode.field_dp = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  Mode done = mode;
  done.name = "done";
  system.modes = {mode, done};
  Event event;
  event.name = "strike";
  event.to = 1;
  event.guard.value = [h](double, const Vector& x, const Vector&) { return h(x[0]); };
  event.guard.dx = [slope](double, const Vector& x, const Vector&, Vector& g) { g[0] = slope(x[0]); };
  system.events = {event};
  return system;
}

Trajectory run_clock(const HybridSystem& system, double start, double t_end, const FlowOptions& options = {}) {
  return simulate(system, Vector(0), 0.0, vector({start}), {.t_end = t_end, .max_events = 1}, options);
}

}  // namespace

TEST_CASE("the general integrator has order 8 in the state and in the event time") {
  const HybridSystem system = make_oscillator("cantilever", "newton");
  const Vector p = parameters(system, {{"r", 0.6}, {"eta", 0.7}, {"xi", 0.5}});
  const Vector x0 = vector({-0.6, -1.0});
  const auto with_step = [&](double h) {  // a tolerance that is always met: every step has length max_step
    Flow flow = make_flow(system, 0, p, {}, {.kind = FlowKind::general, .tolerance = 1.0, .max_step = h});
    Segment segment;
    flow.carry({0.0, 10.0, Sensitivity::none}, x0, segment);
    return segment;
  };
  const Segment guess = with_step(0.05);
  REQUIRE(guess.end == FlowEnd::event);
  const Impact exact = cantilever_impact(p, 0.0, x0, guess.t1);
  const double h = 0.5;
  const Segment coarse = with_step(h), fine = with_step(h / 4);
  // The segment starts with a few smaller steps, so that the ratio of errors is not exactly 4^8.
  const double order_t = std::log(std::abs(coarse.t1 - exact.t) / std::abs(fine.t1 - exact.t)) / std::log(4.0);
  const double order_v = std::log(std::abs(coarse.x1[1] - exact.v) / std::abs(fine.x1[1] - exact.v)) / std::log(4.0);
  INFO("event time errors " << coarse.t1 - exact.t << " " << fine.t1 - exact.t << "; speed errors " << coarse.x1[1] - exact.v
                            << " " << fine.x1[1] - exact.v);
  CHECK(order_t > 7.5);
  CHECK(order_v > 7.5);
}

TEST_CASE("the errors of state and event time of the general flow fall in proportion to the tolerance") {
  const HybridSystem system = make_oscillator("cantilever", "newton");
  for (const double eta : {0.7, 1.6}) {
    const Vector p = parameters(system, {{"r", 0.6}, {"eta", eta}, {"xi", 0.5}});
    const Vector x0 = vector({-0.6, -1.0});
    const auto with_tolerance = [&](double tolerance) {
      Flow flow = make_flow(system, 0, p, {}, {.kind = FlowKind::general, .tolerance = tolerance, .max_step = 10.0});
      Segment segment;
      flow.carry({0.0, 10.0, Sensitivity::none}, x0, segment);
      REQUIRE(segment.end == FlowEnd::event);
      return segment;
    };
    const Impact exact = cantilever_impact(p, 0.0, x0, with_tolerance(1e-12).t1);
    for (const double tolerance : {1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-13}) {
      const Segment segment = with_tolerance(tolerance);
      INFO("eta " << eta << ", tolerance " << tolerance);
      // Each of some ten steps has an error of at most the tolerance, which the flight amplifies by less than 10.
      CHECK(std::abs(segment.t1 - exact.t) < 30.0 * tolerance + 1e-14);
      CHECK(std::abs(segment.x1[1] - exact.v) < 30.0 * tolerance + 1e-14);
    }
  }
}

TEST_CASE("max_step bounds the steps of the general integrator and is a sixteenth of the forcing period by default") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"xi", 0.0}, {"eta", 0.5}, {"r", 9.0}});
  const auto evaluations = [&](double max_step, double tolerance) {
    Flow flow = make_flow(system, 0, p, {}, {.kind = FlowKind::general, .tolerance = tolerance, .max_step = max_step});
    Segment segment;
    flow.carry({0.0, 4.0 * pi, Sensitivity::none}, vector({1.0, 0.0}), segment);
    return segment.evaluations;
  };
  // Thirteen evaluations a step. Over one period the default needs sixteen steps or a few more; half of max_step needs twice
  // as many.
  const double sixteenth = 4.0 * pi / 16.0;
  CHECK(evaluations(0.0, 1.0) == evaluations(sixteenth, 1.0));
  CHECK(evaluations(0.0, 1.0) >= 16 * 13);
  CHECK(evaluations(0.0, 1.0) < 24 * 13);
  CHECK(evaluations(sixteenth / 8, 1.0) >= 128 * 13);
  CHECK(evaluations(100.0, 1.0) < evaluations(0.0, 1.0));
}

TEST_CASE("more than max_steps steps end a segment as failed at the time reached") {
  const HybridSystem system = make_oscillator("cantilever", "hertz");
  for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
    for (const std::size_t mode : {0, 1}) {
      const Vector p = parameters(system, {{"r", mode == 0 ? 5.0 : -1.0}, {"xi", 0.1}});
      const Vector x0 = vector({mode == 0 ? 0.5 : -0.95, 0.0});
      Flow flow = make_flow(system, mode, p, {}, {.kind = kind, .max_steps = 7});
      Segment segment;
      flow.carry({0.0, 1000.0, Sensitivity::none}, x0, segment);
      REQUIRE(segment.end == FlowEnd::failed);
      REQUIRE(segment.t1 > 0.0);
      REQUIRE(segment.t1 < 1000.0);
      REQUIRE(segment.x1.allFinite());
      const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 1000.0}, {.kind = kind, .max_steps = 7});
      REQUIRE(run.termination == Termination::integration_failed);
      REQUIRE(run.segments.back().end == FlowEnd::failed);
      // The final state is a state of the motion.
      const Trajectory there = simulate(system, p, 0.0, x0, {.t_end = segment.t1}, {.kind = kind});
      REQUIRE((there.x - segment.x1).norm() < 1e-11);
    }
  }
}

TEST_CASE("a state that grows without bound ends the run as an escape") {
  // x'' = x^3 (beta < 0 beyond its barrier) reaches infinity in finite time.
  const HybridSystem system = make_oscillator("cantilever", "newton");
  const Vector p = parameters(system, {{"beta", -1.0}, {"r", 10.0}, {"xi", 0.0}});
  for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
    const Trajectory run = simulate(system, p, 0.0, vector({-2.0, -1.0}), {.t_end = 50.0}, {.kind = kind, .max_steps = 3000});
    REQUIRE(run.termination == Termination::escape);
  }
}

TEST_CASE("a field with NaN in one component ends the run as failed") {
  HybridSystem system = clock_with_guard([](double) { return -1.0; }, [](double) { return 0.0; });
  system.states = 2;
  for (Mode& mode : system.modes)
    mode.field = [](double, const Vector& x, const Vector&, Vector& f) { f << 1.0, std::sqrt(1.0 - x[0]); };
  system.events.clear();
  const Trajectory run = simulate(system, Vector(0), 0.0, vector({0.0, 0.0}), {.t_end = 5.0}, {.max_steps = 2000});
  REQUIRE(run.termination == Termination::integration_failed);
  REQUIRE(run.t < 1.0 + 1e-9);
}

TEST_CASE("a guard that rises above zero and falls again within one step is detected for any slopes at the ends") {
  // Cubic guards with two roots close together, or far apart, inside one step. The field would allow a step as long as the
  // run.
  struct Shape {
    double (*h)(double);
    double (*slope)(double);
    double first;
  };
  const Shape shapes[] = {
      // up through 0.3, down through 0.4, up through 2: rising at both ends of [0, 1.6]
      {[](double x) { return (x - 0.3) * (x - 0.4) * (x - 2.0); },
       [](double x) { return (x - 0.4) * (x - 2.0) + (x - 0.3) * (x - 2.0) + (x - 0.3) * (x - 0.4); }, 0.3},
      // falling at the start, up through 0.7, down through 0.9
      {[](double x) { return -(x + 0.5) * (x - 0.7) * (x - 0.9); },
       [](double x) { return -((x - 0.7) * (x - 0.9) + (x + 0.5) * (x - 0.9) + (x + 0.5) * (x - 0.7)); }, 0.7},
      // two maxima within the step
      {[](double x) { return std::sin(4.0 * pi * x) - 0.9999; }, [](double x) { return 4.0 * pi * std::cos(4.0 * pi * x); },
       std::asin(0.9999) / (4.0 * pi)},
  };
  for (const Shape& shape : shapes) {
    const HybridSystem system = clock_with_guard(shape.h, shape.slope);
    for (const double t_end : {0.95, 1.0, 1.3, 1.6, 160.0}) {  // the first step is a hundredth of the run
      for (const double start : {-0.4, -0.1, 0.0, 0.05}) {
        if (shape.h(start) >= 0.0) continue;
        const Trajectory run = run_clock(system, start, t_end - start);
        INFO("guard " << &shape - shapes << ", start " << start << ", run to " << t_end);
        REQUIRE(run.events.size() == 1);
        if (start > -0.1) REQUIRE(run.x[0] == Approx(shape.first).margin(1e-12));
      }
    }
  }
}

TEST_CASE("a guard that stays at zero does not fire and neither does one that touches zero from below") {
  const HybridSystem flat = clock_with_guard([](double) { return 0.0; }, [](double) { return 0.0; });
  REQUIRE(run_clock(flat, 0.0, 5.0).events.empty());
  const HybridSystem touching =
      clock_with_guard([](double x) { return -(x - 1.0) * (x - 1.0); }, [](double x) { return -2.0 * (x - 1.0); });
  REQUIRE(run_clock(touching, 0.0, 5.0).events.empty());
  const HybridSystem flat_crossing =
      clock_with_guard([](double x) { return std::pow(x - 1.0, 3.0); }, [](double x) { return 3.0 * (x - 1.0) * (x - 1.0); });
  const Trajectory run = run_clock(flat_crossing, 0.0, 5.0);
  REQUIRE(run.events.size() == 1);
  // A triple root has the error (rounding)^(1/3).
  REQUIRE(run.x[0] == Approx(1.0).margin(1e-4));
}

TEST_CASE("a rebound below the rounding of x does not stall the general flow") {
  // Found in chatter between two rigid stops: x = -r + 1e-17 rounds to -r, although the speed shows that the barrier is near.
  const HybridSystem system = two_sided_oscillator(true);
  const Vector p = parameters(system, {{"b", 0.05}, {"r", 0.7}, {"eta", 0.9}, {"k_r", 0.8}});
  for (const double v : {4.2752865486225654e-09, 1e-8, 1e-7}) {
    Flow flow = make_flow(system, 0, p, {}, {.kind = FlowKind::general});
    Segment out;
    flow.carry({4.255606850617113, forcing_period(system, p), Sensitivity::none}, vector({-0.7, v}), out);
    CHECK(out.evaluations < 100000);
  }
}

TEST_CASE("events simultaneous up to rounding fire in the order of their declaration") {
  // Three clocks of different rates reach their marks at t = 0.7 with different rounding errors.
  for (const double rate : {3.0, 0.1, 7.77, 1.0 / 3.0}) {
    HybridSystem system = clock_with_guard([](double x) { return x - 0.7; }, [](double) { return 1.0; });
    system.states = 3;
    for (Mode& mode : system.modes)
      mode.field = [rate](double, const Vector& x, const Vector&, Vector& f) { f << 1.0, rate, std::cos(x[0]); };
    const auto mark = [&](const char* name, Eigen::Index which, double level) {
      Event event;
      event.name = name;
      event.guard.value = [=](double, const Vector& x, const Vector&) { return x[which] - level; };
      event.guard.dx = [=](double, const Vector&, const Vector&, Vector& g) { g.setUnit(which); };
      event.reset.map = [=](double, const Vector& x, const Vector&, Vector& out) {
        out = x;
        out[which] = level - 100.0;  // far from its mark, while the other clocks keep their values
      };
      event.reset.dx = [=](double, const Vector&, const Vector&, Matrix& J) {
        J.setIdentity();
        J(which, which) = 0.0;
      };
      return event;
    };
    std::vector<Event> marks = {mark("unit", 0, 0.7), mark("rate", 1, rate * 0.7), mark("sine", 2, std::sin(0.7))};
    std::sort(marks.begin(), marks.end(), [](const Event& a, const Event& b) { return a.name < b.name; });
    do {
      system.events = marks;
      const Trajectory run = simulate(system, Vector(0), 0.0, vector({0.0, 0.0, 0.0}), {.t_end = 1.0, .max_events = 3});
      INFO("rate " << rate << ": " << marks[0].name << ", " << marks[1].name << ", " << marks[2].name);
      REQUIRE(run.events.size() == 3);
      for (std::size_t i = 0; i < 3; ++i) {
        CHECK(run.events[i].event == i);
        CHECK(run.events[i].t == Approx(0.7).margin(1e-13));
      }
    } while (std::next_permutation(marks.begin(), marks.end(), [](const Event& a, const Event& b) { return a.name < b.name; }));
  }
}
