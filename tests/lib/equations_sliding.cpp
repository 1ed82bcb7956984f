// SPDX-License-Identifier: GPL-3.0-or-later
// Surfaces on which two modes meet, and dry friction. A block on a belt is written both ways and compared with an independent
// integration.
#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

/// x'' = -x - c x' + friction, belt of speed V, friction coefficient mu_s/(1 + delta |v - V|).
SystemWriter belt_as_surface(const std::string& sliding = "stick") {
  SystemWriter writer;
  writer.system.name = "belt";
  writer.states({"x", "v"}).parameter("V", "0.5").parameter("mu_s", "1").parameter("delta", "3").parameter("c", "0");
  writer.mode("slower", "x' = v; v' = -x - c*v + mu_s/(1 - delta*(v - V))");
  writer.mode("faster", "x' = v; v' = -x - c*v - mu_s/(1 + delta*(v - V))");
  writer.surface("v - V", "slower", "faster", sliding);
  return writer;
}
SystemWriter belt_as_friction(const std::string& law = "mu_s/(1 + delta*u)", const std::string& sticking = "") {
  SystemWriter writer;
  writer.system.name = "belt";
  writer.parameter("V", "0.5").parameter("mu_s", "1").parameter("delta", "3").parameter("c", "0");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"c"}}, {{"1"}}, {"0"}});
  writer.friction("belt", "v - V", "1", law, sticking);
  return writer;
}

/// The slip that begins at the sticking limit x = mu_s. RK4 with small steps until v = V again. Results: its duration, and x
/// there.
struct Slip {
  double duration, x;
};
Slip slip(double V, double mu_s, double delta, double kinetic) {
  double x = mu_s, v = V, t = 0.0;
  const auto a = [&](double q, double u) { return -q + kinetic / (1.0 + delta * (V - u)); };
  const auto step = [&](double h, double& q, double& u) {
    const double k1 = u, l1 = a(q, u), k2 = u + 0.5 * h * l1, l2 = a(q + 0.5 * h * k1, k2);
    const double k3 = u + 0.5 * h * l2, l3 = a(q + 0.5 * h * k2, k3), k4 = u + h * l3, l4 = a(q + h * k3, k4);
    q += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    u += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
  };
  double h = 1e-4;
  bool left = false;
  for (;;) {
    double q = x, u = v;
    step(h, q, u);
    left = left || u < V - 1e-3;
    if (left && u >= V) {
      if (h < 1e-13) return {t, x};
      h *= 0.5;  // bisect the step
      continue;
    }
    x = q;
    v = u;
    t += h;
  }
}

}  // namespace

TEST_CASE("stick-slip of a block on a belt as a surface and as friction agrees with an independent integration") {
  const Slip reference = slip(0.5, 1.0, 3.0, 1.0);
  for (const bool as_surface : {true, false}) {
    const HybridSystem system = equations::make_system((as_surface ? belt_as_surface() : belt_as_friction()).system).system;
    INFO((as_surface ? "surface" : "friction"));
    const Vector p = default_parameters(system.parameters);
    REQUIRE(!is_forced(system));
    REQUIRE(system.modes.size() == 3);
    const Trajectory run = simulate(system, p, 0.0, vector({0.0, 0.2}), {.t_end = 60.0});
    REQUIRE(run.termination == Termination::time);
    std::vector<EventRecord> sticks, leaves;
    for (const EventRecord& one : run.events) {
      if (one.kind == EventKind::stick) sticks.push_back(one);
      if (one.kind == EventKind::release) leaves.push_back(one);
    }
    REQUIRE(sticks.size() > 4);
    REQUIRE(sticks.size() + leaves.size() == run.events.size());
    for (std::size_t i = 0; i + 1 < leaves.size(); ++i) {
      REQUIRE(leaves[i].x_minus[1] == 0.5);                         // a sticking block has exactly the speed of the belt
      REQUIRE(leaves[i].x_minus[0] == Approx(1.0).epsilon(1e-11));  // sticking lasts until the spring pulls with mu_s
      const EventRecord& next = sticks[i + 1];
      REQUIRE(next.t - leaves[i].t == Approx(reference.duration).epsilon(1e-8));
      REQUIRE(next.x_plus[0] == Approx(reference.x).epsilon(1e-8));
      REQUIRE(leaves[i + 1].t - next.t == Approx((1.0 - reference.x) / 0.5).epsilon(1e-8));
    }
    const Vector x = vector({0.3, 0.2});
    for (std::size_t mode = 0; mode < system.modes.size(); ++mode) {
      const bool faster = system.modes[mode].name == "faster" || system.modes[mode].name == "belt forward";
      REQUIRE_THAT(check_mode(system, mode, 0.0, vector({0.3, faster ? 0.9 : 0.2}), p), all_agree());
    }
    for (std::size_t event = 0; event < system.events.size(); ++event)
      REQUIRE_THAT(check_event(system, event, 0.0, x, p), all_agree());
    // In a cycle one direction is lost completely: one multiplier is exactly zero. The other one belongs to the shift in time.
    Propagator propagator(system, p);
    Transition transition;
    const double period = leaves[2].t - leaves[1].t;
    carry(propagator, 0.0, period, vector({0.0, 0.5}), {}, transition);
    REQUIRE(transition.Phi.row(1).isZero(0.0));
    REQUIRE(transition.x1[0] == Approx(0.0).margin(1e-9));
    REQUIRE(transition.Phi(0, 0) == Approx(1.0).epsilon(1e-9));
    REQUIRE_THAT(check_transition(system, p, 0.0, 9.0, vector({0.1, 0.2}), 1e-7, 1e-5), all_agree());
  }
}

TEST_CASE("a static coefficient above the sliding one delays the slip and makes the force jump where it begins") {
  const HybridSystem system = equations::make_system(belt_as_friction("0.6/(1 + delta*u)", "mu_s").system).system;
  const Vector p = default_parameters(system.parameters);
  const Slip reference = slip(0.5, 1.0, 3.0, 0.6);
  const Trajectory run = simulate(system, p, 0.0, vector({0.0, 0.2}), {.t_end = 40.0});
  std::size_t slips = 0;
  for (std::size_t i = 0; i + 1 < run.events.size(); ++i) {
    const EventRecord &leave = run.events[i], &stick = run.events[i + 1];
    if (leave.kind != EventKind::release) continue;
    ++slips;
    REQUIRE(!system.events[leave.event].continuous);
    REQUIRE(leave.x_minus[0] == Approx(1.0).epsilon(1e-11));
    REQUIRE(stick.kind == EventKind::stick);
    REQUIRE(stick.t - leave.t == Approx(reference.duration).epsilon(1e-8));
    REQUIRE(stick.x_plus[0] == Approx(reference.x).margin(1e-8));
  }
  REQUIRE(slips > 3);
  REQUIRE_THAT(check_transition(system, p, 0.0, 9.0, vector({0.1, 0.2}), 1e-7, 1e-5), all_agree());
}

TEST_CASE("Coulomb friction stops a free mass for good and a strong spring drives it through rest without sticking") {
  SystemWriter writer;
  writer.system.name = "coulomb";
  writer.parameter("m", "2").parameter("k", "3").parameter("mu", "0.3").parameter("N", "1");
  writer.mechanics({"x"}, {"v"}, {{{"m"}}, {}, {{"k"}}}).friction("ground", "v", "N", "mu");
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = default_parameters(system.parameters);
  // The amplitude falls by 2 mu N / k each half period, until the spring at rest pulls less than mu N.
  const Trajectory run = simulate(system, p, 0.0, vector({1.05, 0.0}), {.t_end = 40.0});
  const double w = std::sqrt(3.0 / 2.0), drop = 2.0 * 0.3 / 3.0;
  REQUIRE(run.events.size() == 5);
  double amplitude = 1.05;
  std::size_t turns = 0;
  for (const EventRecord& one : run.events) {
    ++turns;
    amplitude -= drop;
    REQUIRE(one.t == Approx(static_cast<double>(turns) * std::numbers::pi / w).epsilon(1e-10));
    REQUIRE(std::abs(one.x_plus[0]) == Approx(amplitude).margin(1e-9));
    REQUIRE((one.kind == EventKind::stick) == (3.0 * amplitude < 0.3));
  }
  REQUIRE(system.modes[run.mode].name == "ground stick");
  REQUIRE(run.x[1] == 0.0);
}

TEST_CASE("a mass is released from dry friction in the direction of its force, whatever the size of the forces (fixed)") {
  // The forces balance at the release: their difference there is rounding, which may drive the mass back. m, k, the amplitude
  // of the force and the friction are multiples of `size`: the motion does not depend on it.
  for (const char* const sticking : {"", "f_static"})
    for (const double omega : {0.3, 0.37, 0.45})
      for (const double f : {0.75, 0.8, 0.86}) {
        std::optional<Trajectory> unit;
        for (const double size : {1.0, 3.0, 1e3, 7e6, 1e-4}) {
          SystemWriter writer;
          writer.parameter("size", fmt::format("{}", size)).parameter("omega", fmt::format("{}", omega));
          writer.parameter("f", fmt::format("{}", f)).parameter("f_static", fmt::format("{}", f));
          writer.mechanics({"x"}, {"v"}, {{{"size"}}, {}, {{"size"}}, {"size*cos(omega*t)"}});
          writer.friction("floor", "v", "size", "f", sticking).forcing("omega");
          const HybridSystem system = equations::make_system(writer.system).system;
          const Vector p = default_parameters(system.parameters);
          INFO("omega " << omega << " f " << f << " size " << size << " " << sticking);
          const Trajectory run = simulate(system, p, 0.0, Vector::Zero(2), {.t_end = 100.0 * forcing_period(system, p)});
          REQUIRE(run.termination == Termination::time);
          // Two stops and two releases a period.
          REQUIRE(run.events.size() > 390);
          for (std::size_t i = 0; i + 1 < run.events.size(); ++i) {
            REQUIRE(run.events[i + 1].t > run.events[i].t);
            REQUIRE((run.events[i].kind == EventKind::release) != (run.events[i + 1].kind == EventKind::release));
          }
          if (!unit) unit = run;
          REQUIRE(run.events.size() == unit->events.size());
          REQUIRE((run.x - unit->x).norm() < 1e-10);
        }
      }
}

TEST_CASE("an impact that ends at speed zero leaves another friction on the side on which it slips (fixed)") {
  SystemWriter writer;
  writer.parameter("omega", "1.604391").parameter("mu", "0.369166").parameter("g", "0.120942").parameter("e", "0.1368");
  writer.parameter("c", "0.085955").parameter("a", "1.320988");
  writer.mechanics({"x", "y"}, {"v", "w"},
                   {{{"1", "0"}, {"0", "0.7"}},
                    {{"c", "0"}, {"0", "0.05"}},
                    {{"1.4", "-0.4"}, {"-0.4", "0.9"}},
                    {"a*cos(omega*t)", "0.3*sin(omega*t)"}});
  writer.friction("floor", "v", "1", "mu*(0.6 + 0.4/(1 + 3*u))").friction("between", "w - v", "0.4", "mu");
  writer.stop("wall", "g - x", "newton", {"e"}).forcing("omega");
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = default_parameters(system.parameters);
  const Trajectory run =
      simulate(system, p, 0.0, Vector::Zero(4), {.t_end = 60.0 * forcing_period(system, p), .max_events = 5000});
  REQUIRE(run.termination == Termination::time);
  // The second mass slips to the side of its speed in every mode.
  for (const EventRecord& one : run.events) {
    const double speed = one.x_plus[3] - one.x_plus[2];
    const std::string& mode = system.modes[one.mode_plus].name;
    INFO("t = " << one.t << ", " << mode);
    if (mode.find("between forward") != std::string::npos) CHECK(speed >= -1e-12);
    if (mode.find("between backward") != std::string::npos) CHECK(speed <= 1e-12);
  }
}

TEST_CASE("a surface that is only crossed: both directions without a sliding mode") {
  SystemWriter writer;
  writer.system.name = "crossed";
  writer.states({"x", "v"}).parameter("a", "0.5");
  writer.mode("left", "x' = v; v' = -x").mode("right", "x' = v; v' = -x - a*x");
  writer.surface("x", "left", "right");
  const HybridSystem system = equations::make_system(writer.system).system;
  REQUIRE(system.modes.size() == 2);
  REQUIRE(system.events.size() == 2);
  REQUIRE(system.events[0].continuous);  // the fields agree on the surface
  const Vector p = default_parameters(system.parameters);
  const double period = std::numbers::pi * (1.0 + 1.0 / std::sqrt(1.5));
  const Trajectory run = simulate(system, p, 0.0, vector({0.0, 1.0}), {.t_end = 3.0 * period - 0.1});
  REQUIRE(run.events.size() >= 5);
  for (std::size_t i = 2; i < run.events.size(); ++i)
    REQUIRE(run.events[i].t - run.events[i - 2].t == Approx(period).epsilon(1e-10));
}

TEST_CASE("a curved surface: sliding along a circle stays on it at the rate of the tangential field") {
  SystemWriter writer;
  writer.system.name = "circle";
  writer.states({"x", "y"}).parameter("k", "2").parameter("w", "0.7");
  writer.mode("inside", "x' = k*x - w*y; y' = k*y + w*x").mode("outside", "x' = -k*x - w*y; y' = -k*y + w*x");
  writer.surface("x^2 + y^2 - 1", "inside", "outside", "rim");
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = default_parameters(system.parameters);
  const Trajectory run = simulate(system, p, 0.0, vector({0.5, 0.0}), {.t_end = 5.0});
  REQUIRE(system.modes[run.mode].name == "rim");
  REQUIRE(run.x.norm() == Approx(1.0).epsilon(1e-11));
  REQUIRE(mode_at(system, 0.0, run.x, p) == run.mode);
  const double angle = 0.7 * 5.0;
  REQUIRE(run.x[0] == Approx(std::cos(angle)).margin(1e-10));
  REQUIRE(run.x[1] == Approx(std::sin(angle)).margin(1e-10));
  for (std::size_t mode = 0; mode < 3; ++mode) REQUIRE_THAT(check_mode(system, mode, 0.0, vector({0.8, 0.5}), p), all_agree());
  REQUIRE_THAT(check_transition(system, p, 0.0, 3.0, vector({0.5, 0.1}), 1e-7, 1e-5), all_agree());
}

TEST_CASE("friction and a rigid stop: an impact ends the sticking or reverses the slip and the signs follow its speed") {
  SystemWriter writer;
  writer.system.name = "belt-and-wall";
  writer.parameter("V", "0.5").parameter("r", "0.5").parameter("k_r", "0.6").parameter("mu", "1");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {}, {{"1"}}, {}});
  writer.stop("wall", "r - x", "newton", {"k_r"}).friction("belt", "v - V", "1", "mu/(1 + 3*u)");
  const HybridSystem system = equations::make_system(writer.system).system;
  // The belt moves, so that a block held at the wall does not stick to it.
  REQUIRE(system.modes.size() == 5);
  const Vector p = default_parameters(system.parameters);
  const Trajectory run = simulate(system, p, 0.0, vector({0.0, 0.5}), {.t_end = 30.0});
  REQUIRE(run.termination == Termination::time);
  REQUIRE(run.events[0].kind == EventKind::impact);
  REQUIRE(run.events[0].t == Approx(1.0).epsilon(1e-11));  // the belt carries the block to the wall
  REQUIRE(run.events[0].x_plus[1] == Approx(-0.3).epsilon(1e-13));
  REQUIRE(system.modes[run.events[0].mode_plus].name == "belt backward");
  int stuck = 0;
  for (const EventRecord& one : run.events) {
    const std::string& mode = system.modes[one.mode_plus].name;
    const double u = one.x_plus[1] - 0.5;
    stuck += mode == "belt stick" ? 1 : 0;
    if (mode == "belt backward") REQUIRE(u < 1e-9);
    if (mode == "belt forward") REQUIRE(u > -1e-9);
    if (mode == "belt stick") REQUIRE(u == 0.0);
  }
  REQUIRE(stuck > 0);
  // Finally the friction of the belt, 1/(1 + 3/2) = 0.4, cannot hold the block at the wall against the spring, 0.5.
  REQUIRE(std::none_of(run.events.begin(), run.events.end(), [](const EventRecord& one) { return one.x_plus[0] > 0.5; }));
  for (std::size_t event = 0; event < system.events.size(); ++event)
    REQUIRE_THAT(check_event(system, event, 0.0, vector({0.3, 0.2}), p), all_agree());
}

TEST_CASE("two coupled blocks on a belt stick and slip separately: speeds and limits hold and derivatives are exact") {
  SystemWriter writer;
  writer.system.name = "blocks";
  writer.parameter("V", "0.3").parameter("k", "1.2").parameter("mu", "1").parameter("N2", "1.4");
  writer.mechanics({"x", "y"}, {"v", "w"}, {{{"1", "0.1"}, {"0.1", "1.5"}}, {}, {{"1 + k", "-k"}, {"-k", "1 + k"}}, {}});
  writer.friction("a", "v - V", "1", "mu/(1 + 2*u)").friction("b", "w - V", "N2", "mu/(1 + 2*u)");
  const HybridSystem system = equations::make_system(writer.system).system;
  REQUIRE(system.modes.size() == 9);
  const Vector p = default_parameters(system.parameters), x0 = vector({0.1, -0.2, 0.1, 0.2});
  const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 30.0});
  REQUIRE(run.termination == Termination::time);
  std::size_t both = 0;
  for (const Segment& segment : run.segments) {
    const std::string& name = system.modes[segment.mode].name;
    const bool a = name.find("a stick") != std::string::npos, b = name.find("b stick") != std::string::npos;
    both += a && b;
    if (a) REQUIRE(segment.x1[2] == 0.3);
    if (b) REQUIRE(segment.x1[3] == 0.3);
    // Both stick to the belt: there is no acceleration, and the springs balance the friction alone.
    if (!a || !b) continue;
    REQUIRE(std::abs(2.2 * segment.x1[0] - 1.2 * segment.x1[1]) <= 1.0 + 1e-9);
    REQUIRE(std::abs(2.2 * segment.x1[1] - 1.2 * segment.x1[0]) <= 1.4 + 1e-9);
  }
  REQUIRE(both > 2);
  REQUIRE_THAT(check_transition(system, p, 0.0, 10.0, x0, 1e-7, 1e-5), all_agree());
}

TEST_CASE("a reset of the text ends the sliding if it leaves the surface and crosses to the side of its final state") {
  SystemWriter writer = belt_as_surface();
  writer.parameter("r", "0.5").event({"wall", "impact", "x - r", "v = -0.6*v", "", ""});
  const HybridSystem system = equations::make_system(writer.system).system;
  SystemWriter other = belt_as_friction();
  other.parameter("r", "0.5").stop("wall", "r - x", "newton", {"0.6"});
  const HybridSystem mechanics = equations::make_system(other.system).system;
  SystemWriter third = belt_as_friction();
  third.parameter("r", "0.5").event({"wall", "impact", "x - r", "v = -0.6*v", "", ""});
  const HybridSystem mixed = equations::make_system(third.system).system;
  for (const double v0 : {0.5, 1.4, 0.2}) {
    const Vector x0 = vector({0.0, v0});
    const Trajectory a = simulate(system, default_parameters(system.parameters), 0.0, x0, {.t_end = 6.0});
    REQUIRE(a.termination == Termination::time);
    REQUIRE(a.events.size() > 2);
    for (const HybridSystem* same : {&mechanics, &mixed}) {
      const Trajectory b = simulate(*same, default_parameters(same->parameters), 0.0, x0, {.t_end = 6.0});
      REQUIRE(a.events.size() == b.events.size());
      REQUIRE((a.x - b.x).norm() < 1e-10);
    }
    for (const EventRecord& one : a.events) {
      if (one.kind != EventKind::impact) continue;
      REQUIRE(one.x_plus[1] == Approx(-0.6 * one.x_minus[1]).epsilon(1e-13));
      REQUIRE(system.modes[one.mode_plus].name == "slower");
    }
  }
}

TEST_CASE("each mistake in surfaces and friction gives one sentence with its place") {
  const auto mistake = [](const equations::SystemText& text) -> std::string {
    try {
      equations::make_system(text);
    } catch (const equations::EquationError& error) {
      return error.sentence();
    }
    return "none";
  };
  SystemWriter base;
  base.states({"x"}).parameter("a", "1").mode("one", "x' = 1").mode("two", "x' = -1");  // lines 1 to 7
  const auto surface = [&](const std::string& function, const std::string& below, const std::string& above,
                           const std::string& sliding) {
    SystemWriter writer = base;
    return mistake(writer.surface(function, below, above, sliding).system);
  };
  REQUIRE(surface("a", "one", "two", "slide") ==
          "system.toml:8:1: the function of a surface does not depend on the motion: no state stands in it");
  REQUIRE(surface("x", "on", "two", "slide") == "system.toml:9:1: a surface names an unknown mode 'on'; did you mean 'one'?");
  REQUIRE(surface("x", "one", "one", "slide") == "system.toml:10:1: the mode one stands on both sides of a surface");
  REQUIRE(surface("x", "one", "two", "two") == "system.toml:11:1: a mode called 'two' exists already");
  REQUIRE(surface("x - t", "one", "two", "slide") == "system.toml:8:1: the guard of slide from below depends on the time, but "
                                                     "neither a forcing frequency nor a period is given");
  REQUIRE(mistake(SystemWriter(base).friction("f", "x", "1", "1").system) ==
          "system.toml:8:1: friction needs mechanics, with a mass matrix; without, it is a surface where two modes meet");
  SystemWriter block = belt_as_friction();
  block.system.friction[0].speed = block.write("x");
  REQUIRE(mistake(block.system) == "system.toml:20:1: the speed of belt depends on no velocity");
  block = belt_as_friction("1", "0.5");
  REQUIRE(mistake(block.system) == "system.toml:20:1: the static coefficient of belt is 0.5, less than that of slow sliding, 1");
}
