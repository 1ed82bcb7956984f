// SPDX-License-Identifier: GPL-3.0-or-later
// Stops and friction that act at one instant: carried masses, impacts upon impacts, friction of masses that a stop holds.
#include <graze/lib/motion/trajectory.hpp>

#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace graze;
using namespace graze::support;

TEST_CASE("a carried mass flies on where its carrier hits a wall") {
  // Mass 1 pushes mass 2, on which it came to rest, and hits the wall with restitution e.
  SystemWriter writer;
  writer.system.name = "carrier";
  writer.parameter("e", "0.9");
  writer.mechanics({"x", "y"}, {"v", "w"}, {{{"1", "0"}, {"0", "1"}}, {}, {}, {"1", "0"}});
  writer.stop("wall", "1 - x", "newton", {"e"}).stop("between", "y - x", "newton", {"0"});
  const HybridSystem system = equations::make_system(writer.system).system;
  for (const double e : {0.0, 0.2, 0.9}) {
    INFO("e " << e);
    const Trajectory run = simulate(system, vector({e}), 0.0, vector({0.0, 0.2, 0.0, 0.0}), {.t_end = 1.95});
    REQUIRE(run.events.size() == (e == 0.0 ? 3 : 2));  // with e = 0 it then rests at the wall
    const EventRecord& impact = run.events[1];
    const double speed = std::sqrt(0.9);  // after half of sqrt(0.4) and 0.8 further at the acceleration 1/2
    CHECK(impact.normal_speed == Approx(speed).epsilon(1e-12));
    CHECK(impact.x_plus[2] == Approx(-e * speed).margin(1e-14));
    CHECK(impact.x_plus[3] == Approx(speed).epsilon(1e-12));
    CHECK(impact.exit_speed == Approx(e * speed).margin(1e-14));
    const std::vector<Contact> both = contacts(run.events);
    REQUIRE(both.size() == 2);
    CHECK(both[1].energy_lost == Approx(0.5 * (1.0 - e * e) * speed * speed).epsilon(1e-12));
  }
}

TEST_CASE("static friction holds a mass that its stop releases") {
  // Kinetic friction 0.6; the force cos(t) presses the mass to the wall and pulls it away with 1 at most.
  SystemWriter writer;
  writer.system.name = "block";
  writer.forcing("w").parameter("w", "1").parameter("s", "1.2");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {}, {}, {"cos(w*t)"}});
  writer.stop("wall", "0.5 - x", "newton", {"0"}).friction("floor", "v", "1", "0.6", "s");
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector start = vector({0.0, 1.0});
  const Until until{.t_end = 4.0 * std::numbers::pi};
  const Trajectory held = simulate(system, vector({1.0, 1.2}), 0.0, start, until);
  REQUIRE(held.termination == Termination::time);
  CHECK(held.x == vector({0.5, 0.0}));
  const Trajectory freed = simulate(system, vector({1.0, 0.9}), 0.0, start, until);
  REQUIRE(freed.termination == Termination::time);
  const auto slip = std::find_if(freed.events.begin(), freed.events.end(), [&](const EventRecord& event) {
    return system.events[event.event].name == "floor slip backward";
  });
  REQUIRE(slip != freed.events.end());
  CHECK(slip->t == Approx(std::acos(-0.9)).epsilon(1e-12));
  CHECK(slip->x_plus == vector({0.5, 0.0}));
}

TEST_CASE("impacts of two stops upon each other at one instant have an end") {
  // Two blocks land on a shaking table: the lower one goes back and forth between table and upper block, ever slower.
  SystemWriter writer;
  writer.system.name = "landing";
  writer.forcing("w").parameter("w", "1").parameter("e", "0.7").parameter("A", "2");
  writer.mechanics({"x", "y"}, {"v", "w_y"}, {{{"1", "0"}, {"0", "2"}}, {}, {}, {"-1", "-2"}});
  writer.stop("between", "y - x", "newton", {"0"}).stop("table", "x - A*sin(w*t)", "newton", {"e"});
  const HybridSystem system = equations::make_system(writer.system).system;
  for (const double e : {0.0, 0.3, 0.7}) {
    INFO("e " << e);
    const Trajectory landing = simulate(system, vector({1.0, e, 2.0}), 0.0, vector({2.0, 3.0, 0.0, 0.0}), {.t_end = 4.0});
    REQUIRE(landing.termination == Termination::time);
    CHECK(landing.events.size() < 200);
    // With e = 0.7 they land here for the first time, and rest on the table; otherwise it throws them up again.
    if (e != 0.7) continue;
    CHECK(system.modes[landing.mode].name == "between+table");
    const double x = 2.0 * std::sin(4.0), v = 2.0 * std::cos(4.0);
    CHECK(landing.x.isApprox(vector({x, x, v, v}), 1e-12));
  }
}

TEST_CASE("a bouncing ball moves in the same way in any unit of time") {
  SystemWriter writer;
  writer.system.name = "ball";
  writer.forcing("w").parameter("w", "1").parameter("g", "1");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {}, {}, {"-g"}});
  writer.stop("table", "x - 0.5*sin(w*t)", "newton", {"0.3"});
  const HybridSystem system = equations::make_system(writer.system).system;
  const auto position = [&](double rate) {
    const Trajectory run = simulate(system, vector({1.6 * rate, rate * rate}), 0.0, vector({0.6, 0.0}), {.t_end = 50.0 / rate});
    REQUIRE(run.termination == Termination::time);
    return run.x[0];
  };
  const double expected = position(1.0);
  for (const double rate : {1e-4, 3.1e-4, 0.01, 0.3, 4.0, 1e3, 1e5, 1e6}) {
    INFO("rate " << rate);
    CHECK(position(rate) == Approx(expected).margin(1e-9));
  }
}

TEST_CASE("samples of a motion do not depend on their number where masses touch and friction holds them") {
  SystemWriter writer;
  writer.system.name = "sampled";
  writer.forcing("w").parameter("w", "0.9336");
  writer.mechanics({"x", "y", "z"}, {"v_x", "v_y", "v_z"},
                   {{{"0.5107", "0", "0"}, {"0", "1.017", "0"}, {"0", "0", "2.66"}},
                    {{"0.3134", "-0.1468", "0"}, {"-0.1468", "0.3278", "-0.181"}, {"0", "-0.181", "0.3882"}},
                    {{"1.5632", "-0.2652", "0"}, {"-0.2652", "4.2264", "-3.306"}, {"0", "-3.306", "5.043"}},
                    {"2.195*cos(w*t)", "2.035*cos(w*t)", "0"}});
  writer.stop("between", "x - y + 0.6486", "newton", {"0.581"}).stop("soft", "0.93 - x", "hertz", {"7.802", "0.113"});
  writer.friction("one", "v_x - v_y", "0.9888 + 0.1158*x - 0.149*y - 0.09163*z", "0.7656/(1 + 1.01*u)");
  writer.friction("two", "v_x - 1.5*v_y", "1.271 + 0.1346*x - 0.0399*y + 0.07734*z", "0.2299/(1 + 0.2401*u)");
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = default_parameters(system.parameters);
  const double end = 4.0 * std::numbers::pi / 0.9336;
  const Trajectory run = simulate(system, p, 0.0, Vector::Zero(6), {.t_end = end});
  REQUIRE(run.termination == Termination::time);
  const auto samples = [&](int number) {
    std::vector<double> times;
    for (int i = 0; i <= number; ++i) times.push_back(end * i / number);
    return sample(system, p, run, times);
  };
  const Matrix few = samples(128), many = samples(640);
  for (Eigen::Index i = 0; i + 1 < few.rows(); ++i) CHECK((few.row(i) - many.row(5 * i)).cwiseAbs().maxCoeff() < 1e-9);
}
