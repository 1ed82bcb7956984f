// SPDX-License-Identifier: GPL-3.0-or-later
// abs, sign, max, min, step, clamp and deadzone, split into modes and guards.
#include "support/checks.hpp"
#include "support/system_texts.hpp"
#include "support/two_sided_oscillator.hpp"

using namespace graze;
using namespace graze::support;

namespace {

SystemWriter forced(const std::string& force, const std::vector<std::pair<std::string, std::string>>& parameters = {}) {
  SystemWriter writer;
  writer.system.name = "nonsmooth";
  writer.states({"x", "v"}).forcing("eta").parameter("eta", "0.9").parameter("xi", "1").parameter("b", "0.05");
  for (const auto& [name, value] : parameters) writer.parameter(name, value);
  writer.mode("free", "x' = v\nv' = xi*cos(eta*t) - 2*b*v - x - (" + force + ")");
  return writer;
}

/// The field as written, with its branches, against the field of the mode of the state.
void require_same_field(const equations::TextSystem& read,
                        const std::function<double(double, const Vector&, const Vector&)>& force, bool all_met = true) {
  const HybridSystem& system = read.system;
  Random random(9);
  const Vector p = default_parameters(system.parameters);
  std::vector<int> met(system.modes.size(), 0);
  for (int i = 0; i < 400; ++i) {
    const Vector x = vector({random(-3.0, 3.0), random(-3.0, 3.0)});
    const double t = random(0.0, 9.0);
    const auto mode = mode_at(system, t, x, p);
    REQUIRE(mode.has_value());
    ++met[*mode];
    Vector f(2);
    system.modes[*mode].field(t, x, p, f);
    REQUIRE(f[1] == Approx(p[1] * std::cos(p[0] * t) - 2.0 * p[2] * x[1] - x[0] - force(t, x, p)).margin(1e-13));
    REQUIRE_THAT(check_mode(system, *mode, t, x, p), all_agree());
  }
  for (std::size_t m = 0; m < met.size(); ++m) {
    INFO(system.modes[m].name);
    REQUIRE((met[m] > 0 || !all_met));
  }
}

}  // namespace

TEST_CASE("deadzone: three modes, one combination refuted, continuous crossings, motion of the hand-written system") {
  const HybridSystem given = two_sided_oscillator(false);
  SystemWriter writer = forced("k_S*deadzone(x, r)");
  writer.system.parameters.push_back({.name = writer.write("r"), .value = writer.write("1"), .above = writer.write("0")});
  writer.parameter("k_S", "25");
  const equations::TextSystem read = equations::make_system(writer.system);
  const HybridSystem& system = read.system;
  REQUIRE(system.modes.size() == 3);
  REQUIRE(system.events.size() == 4);
  for (const Event& event : system.events) REQUIRE(event.continuous);
  require_same_field(read, [](double, const Vector& x, const Vector& p) {
    return x[0] > p[3] ? p[4] * (x[0] - p[3]) : x[0] < -p[3] ? p[4] * (x[0] + p[3]) : 0.0;
  });
  const Vector p = parameters(system, {{"xi", 1.7}, {"r", 0.8}}), q = parameters(given, {{"xi", 1.7}, {"r", 0.8}});
  const Vector x0 = vector({0.2, 1.1});
  const double T = forcing_period(system, p);
  const Trajectory a = simulate(given, q, 0.0, x0, {.t_end = 3.0 * T}), b = simulate(system, p, 0.0, x0, {.t_end = 3.0 * T});
  REQUIRE(a.events.size() > 6);
  REQUIRE(a.events.size() == b.events.size());
  REQUIRE((a.x - b.x).norm() < 1e-10);
  REQUIRE_THAT(check_transition(system, p, 0.0, 1.5 * T, x0, 1e-7, 1e-5), all_agree());
}

TEST_CASE("abs, max, min and clamp, also nested, have in each mode the field of their branches") {
  const auto force = [](const std::string& text, const std::function<double(double, const Vector&, const Vector&)>& f,
                        std::size_t modes) {
    INFO(text);
    const equations::TextSystem read = equations::make_system(forced(text).system);
    REQUIRE(read.system.modes.size() == modes);
    for (const Event& event : read.system.events) REQUIRE(event.continuous);
    require_same_field(read, f);
  };
  force(
      "abs(x)*x", [](double, const Vector& x, const Vector&) { return std::abs(x[0]) * x[0]; }, 2);
  force(
      "abs(x) + abs(-x) + max(x, 0)",
      [](double, const Vector& x, const Vector&) { return 2 * std::abs(x[0]) + std::max(x[0], 0.0); }, 2);
  force(
      "abs(x) + abs(v)", [](double, const Vector& x, const Vector&) { return std::abs(x[0]) + std::abs(x[1]); }, 4);
  force(
      "abs(abs(x) - 1)", [](double, const Vector& x, const Vector&) { return std::abs(std::abs(x[0]) - 1.0); }, 4);
  force(
      "clamp(2*x, -1, 1)", [](double, const Vector& x, const Vector&) { return std::clamp(2.0 * x[0], -1.0, 1.0); }, 3);
  force(
      "max(x, min(v, 0.5))", [](double, const Vector& x, const Vector&) { return std::max(x[0], std::min(x[1], 0.5)); }, 4);
  // On one side the speed does not matter.
  force(
      "max(x, 0)*abs(v)", [](double, const Vector& x, const Vector&) { return std::max(x[0], 0.0) * std::abs(x[1]); },
      4);  // the sign of v at x < 0 decides the mode after x = 0
  // The sign of a parameter is not an event.
  force(
      "abs(b)*x + max(b, xi)",
      [](double, const Vector& x, const Vector& p) { return std::abs(p[2]) * x[0] + std::max(p[2], p[1]); }, 1);
}

TEST_CASE("sign and step: the field jumps and the saltation through it agrees with differences") {
  const equations::TextSystem read = equations::make_system(forced("0.3*sign(x) + step(x - 1/2)").system);
  const HybridSystem& system = read.system;
  REQUIRE(system.modes.size() == 3);
  REQUIRE(system.modes[0].name == "free: x - 0.5 > 0");
  for (const Event& event : system.events) REQUIRE(!event.continuous);
  require_same_field(read,
                     [](double, const Vector& x, const Vector&) { return (x[0] > 0 ? 0.3 : -0.3) + (x[0] > 0.5 ? 1.0 : 0.0); });
  const Vector p = parameters(system, {{"xi", 1.7}});
  const Trajectory run = simulate(system, p, 0.0, vector({0.2, 1.1}), {.t_end = 12.0});
  REQUIRE(run.events.size() > 4);
  REQUIRE_THAT(check_transition(system, p, 0.0, 12.0, vector({0.2, 1.1}), 1e-7, 1e-5), all_agree());
  // x sign(x) does not jump.
  const equations::TextSystem smooth = equations::make_system(forced("x*sign(x)").system);
  for (const Event& event : smooth.system.events) REQUIRE(event.continuous);
}

TEST_CASE("the sign of what is zero in a whole region is zero there (fixed)") {
  const auto zone = [](double x) { return x > 0.3 ? x - 0.3 : x < -0.3 ? x + 0.3 : 0.0; };
  const auto sign = [](double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; };
  const std::vector<std::pair<std::string, std::function<double(double, double)>>> forces = {
      {"sign(deadzone(x, 0.3))", [&](double x, double) { return sign(zone(x)); }},
      {"-sign(deadzone(v, 0.3))", [&](double, double v) { return -sign(zone(v)); }},
      {"sign(max(x, 0))", [&](double x, double) { return sign(std::max(x, 0.0)); }},
      {"-0.5*sign(v*max(x, 0))", [&](double x, double v) { return -0.5 * sign(v * std::max(x, 0.0)); }},
      {"sign(min(x, 0) + max(v, 0))", [&](double x, double v) { return sign(std::min(x, 0.0) + std::max(v, 0.0)); }}};
  for (const auto& one : forces) {
    const auto& text = one.first;
    const auto& force = one.second;
    INFO(text);
    const equations::TextSystem read = equations::make_system(forced(text).system);
    require_same_field(read, [&](double, const Vector& x, const Vector&) { return force(x[0], x[1]); });
    const Vector p = parameters(read.system, {{"xi", 1.7}});
    const Trajectory run = simulate(read.system, p, 0.0, vector({0.2, 1.1}), {.t_end = 12.0});
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.events.size() > 2);
    REQUIRE_THAT(check_transition(read.system, p, 0.0, 12.0, vector({0.2, 1.1}), 1e-7, 1e-5), all_agree());
  }
}

TEST_CASE("the sign of a quotient changes at the zeros of its divisor too (fixed)") {
  const HybridSystem quotient = equations::make_system(forced("-sign(0.3/(0.5 - x))").system).system,
                     plain = equations::make_system(forced("-sign(0.5 - x)").system).system;
  REQUIRE(quotient.modes.size() == 2);
  const Vector p = default_parameters(plain.parameters), x0 = vector({0.2, 1.1});
  const Trajectory a = simulate(quotient, p, 0.0, x0, {.t_end = 9.0}), b = simulate(plain, p, 0.0, x0, {.t_end = 9.0});
  REQUIRE(a.termination == Termination::time);
  REQUIRE(a.events.size() >= 2);
  REQUIRE(a.events.size() == b.events.size());
  REQUIRE((a.x - b.x).lpNorm<Eigen::Infinity>() < 1e-11);
  REQUIRE_THAT(check_transition(quotient, p, 0.0, 9.0, x0, 1e-7, 1e-5), all_agree());
}

TEST_CASE("bounded functions of a quotient jump where its divisor passes zero (fixed)") {
  const auto pi = std::numbers::pi;
  const auto angle = [pi](double y, double x) { return x != 0.0 || y != 0.0 ? std::atan2(y, x) : pi; };
  struct Case {
    std::string force;
    std::function<double(const Vector&)> value;
    std::size_t modes;
    bool all_met = true;
  };
  const std::vector<Case> cases = {
      {"0.3*clamp(1/(0.5 - x), -1, 1)", [](const Vector& x) { return 0.3 * std::clamp(1.0 / (0.5 - x[0]), -1.0, 1.0); }, 4},
      {"0.3*clamp(x/(v - 1/4)^3, -1, 2)",
       [](const Vector& x) { return 0.3 * std::clamp(x[0] / std::pow(x[1] - 0.25, 3), -1.0, 2.0); }, 6},
      {"0.3*atan(1/(0.5 - x))", [](const Vector& x) { return 0.3 * std::atan(1.0 / (0.5 - x[0])); }, 2},
      {"0.3*atan(2 + v/(0.5 - x))", [](const Vector& x) { return 0.3 * std::atan(2.0 + x[1] / (0.5 - x[0])); }, 2},
      {"0.3*tanh((x - 0.5)^-1)", [](const Vector& x) { return 0.3 * std::tanh(1.0 / (x[0] - 0.5)); }, 2},
      {"0.3*tanh(tan(x))", [](const Vector& x) { return 0.3 * std::tanh(std::tan(x[0])); }, 2},
      {"0.1*v + 0.3*clamp(clamp(1/x, -2, 2), -1, 1)",
       [](const Vector& x) { return 0.1 * x[1] + 0.3 * std::clamp(std::clamp(1.0 / x[0], -2.0, 2.0), -1.0, 1.0); }, 7, false},
      {"0.3*abs(clamp(1/x, -2, 2) - 1)", [](const Vector& x) { return 0.3 * std::abs(std::clamp(1.0 / x[0], -2.0, 2.0) - 1.0); },
       6, false},
      {"0.3*clamp(max(x/(v - x), 2), -0.5, 1)",
       [](const Vector& x) { return 0.3 * std::clamp(std::max(x[0] / (x[1] - x[0]), 2.0), -0.5, 1.0); }, 8, false},
      {"0.3*atan2(v, x)", [angle](const Vector& x) { return 0.3 * angle(x[1], x[0]); }, 2},
      {"0.2*atan2(1/(x - 0.3), 2 + v^2)", [](const Vector& x) { return 0.2 * std::atan2(1.0 / (x[0] - 0.3), 2.0 + x[1] * x[1]); },
       2},
      {"0.2*atan2(v/(x - 0.3), 1 - x)", [](const Vector& x) { return 0.2 * std::atan2(x[1] / (x[0] - 0.3), 1.0 - x[0]); }, 4},
      {"0.2*abs(atan2(v, x) - 1)", [angle](const Vector& x) { return 0.2 * std::abs(angle(x[1], x[0]) - 1.0); }, 4,
       false},  // angles beyond 1 do not occur at v < 0
      {"0.3*min(1, abs(0.2/(0.5 - x)))", [](const Vector& x) { return 0.3 * std::min(1.0, std::abs(0.2 / (0.5 - x[0]))); }, 4},
      {"0.2*tanh(max(x/(v - 0.3), v/(x - 0.35)))",
       [](const Vector& x) { return 0.2 * std::tanh(std::max(x[0] / (x[1] - 0.3), x[1] / (x[0] - 0.35))); }, 8, false},
      {"0.2*tanh(abs(1/x))", [](const Vector& x) { return 0.2 * std::tanh(std::abs(1.0 / x[0])); }, 2},
      {"0.2*tanh(x/(v - 0.3)*sign(v/(x - 0.35)))",
       [](const Vector& x) { return 0.2 * std::tanh(x[0] / (x[1] - 0.3) * (x[1] / (x[0] - 0.35) > 0.0 ? 1.0 : -1.0)); }, 4},
      {"0.2*atan2(0, x)", [](const Vector& x) { return 0.2 * std::atan2(0.0, x[0]); }, 2},
      {"0.2*atan2(v, step(x))", [](const Vector& x) { return 0.2 * std::atan2(x[1], x[0] >= 0.0 ? 1.0 : 0.0); }, 4, false},
      {"0.3*sign(1 + 1/(0.5 - x))", [](const Vector& x) { return 1.0 + 1.0 / (0.5 - x[0]) > 0.0 ? 0.3 : -0.3; }, 3}};
  for (const Case& one : cases) {
    INFO(one.force);
    const equations::TextSystem read = equations::make_system(forced(one.force).system);
    CHECK(read.system.modes.size() == one.modes);
    require_same_field(
        read, [&](double, const Vector& x, const Vector&) { return one.value(x); }, one.all_met);
    const Vector p = parameters(read.system, {{"xi", 1.7}}), x0 = vector({0.2, 1.1});
    const Trajectory run = simulate(read.system, p, 0.0, x0, {.t_end = 9.0});
    REQUIRE(run.termination == Termination::time);
    REQUIRE(run.events.size() > 1);
    REQUIRE_THAT(check_transition(read.system, p, 0.0, 9.0, x0, 1e-7, 1e-5), all_agree());
  }
  // A quotient that no bounded function takes keeps its mode: its pole is an error.
  REQUIRE(equations::make_system(forced("abs(0.3/(0.5 - x))").system).system.modes.size() == 2);
  REQUIRE(equations::make_system(forced("atan(x) + 1/(4 - x)").system).system.modes.size() == 1);
}

TEST_CASE("an impact within a split mode leads to the branch behind it") {
  SystemWriter writer = forced("0.1*sign(v)");
  writer.parameter("r", "0.7");
  writer.system.parameters.push_back(
      {.name = writer.write("k_r"), .value = writer.write("0.8"), .min = writer.write("0"), .max = writer.write("1")});
  writer.event({"wall", "impact", "x - r", "v = -k_r*v", "", ""});
  const equations::TextSystem read = equations::make_system(writer.system);
  const HybridSystem& system = read.system;
  REQUIRE(system.modes.size() == 2);
  int walls = 0;
  for (const Event& event : system.events) {
    if (event.name != "wall") continue;
    REQUIRE(event.to == 1 - event.from);
    ++walls;
  }
  REQUIRE(walls == 2);
  const Vector p = parameters(system, {{"xi", 1.7}}), x0 = vector({0.2, 1.1});
  const Trajectory run = simulate(system, p, 0.0, x0, {.t_end = 10.0});
  REQUIRE(run.termination == Termination::time);
  int impacts = 0;
  for (const EventRecord& event : run.events) impacts += event.kind == EventKind::impact;
  REQUIRE(impacts > 1);
  REQUIRE_THAT(check_transition(system, p, 0.0, 10.0, x0, 1e-7, 1e-5), all_agree());
}

TEST_CASE("a contact with a sign in its damping is entered on the side given by the rise of the guard") {
  SystemWriter writer = forced("0*x");
  writer.parameter("r", "0.5").parameter("k", "20");
  writer.mode("contact", "x' = v\nv' = xi*cos(eta*t) - 2*b*v - x - k*(x - r)*(1 + 0.2*sign(v))");
  writer.event({"enter", "enter", "x - r", "", "free", "contact"});
  writer.event({"leave", "leave", "r - x", "", "contact", "free"});
  const HybridSystem system = equations::make_system(writer.system).system;
  REQUIRE(system.modes.size() == 3);
  REQUIRE(system.modes[1].name == "contact: v > 0");
  REQUIRE(system.events[0].to == 1);
  REQUIRE(system.events[0].continuous);
  const Vector p = parameters(system, {{"xi", 1.7}}), x0 = vector({0.2, 1.1});
  REQUIRE_THAT(check_transition(system, p, 0.0, 8.0, x0, 1e-7, 1e-5), all_agree());
}

TEST_CASE("nonsmooth functions that cannot be split are refused with a sentence") {
  std::string many = "abs(x)";
  for (int i = 1; i < 8; ++i) many += fmt::format(" + abs(x + {}*v)", i);
  REQUIRE(mistake(forced(many).system) == "system.toml:10:1: the nonsmooth functions of mode free make more than 64 modes of it");
  REQUIRE(mistake(forced("abs(x - sign(v))").system) ==
          "system.toml:10:1: sign or step inside of abs in mode free is not handled; write its modes out");
}

TEST_CASE("a reset without a fixed branch leads to the branch of its final state") {
  SystemWriter writer = forced("0.1*abs(v + 1)", {{"r", "0.7"}});
  writer.event({"wall", "impact", "x - r", "v = -0.3 - 0.8*v", "", ""});
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = default_parameters(system.parameters);
  REQUIRE(system.modes[0].name == "free: v + 1 > 0");
  Propagator propagator(system, p, all_parameters(system));
  for (const double speed : {0.3, 0.8, 1.5}) {
    HybridState state{0.0, vector({0.7, speed}), 0};
    REQUIRE(propagator.step(state, 1.0, Sensitivity::state_and_parameters) == StepEnd::event);
    const double after = -0.3 - 0.8 * speed;
    REQUIRE(state.x[1] == Approx(after).epsilon(1e-15));
    REQUIRE(system.modes[state.mode].name == (after > -1.0 ? "free: v + 1 > 0" : "free: v + 1 < 0"));
    REQUIRE(propagator.segment().event == propagator.record().event);
    REQUIRE(system.events[propagator.record().event].to == state.mode);
  }
  REQUIRE_THAT(check_transition(system, parameters(system, {{"xi", 1.5}}), 0.0, 6.0, vector({0.2, 1.2}), 1e-7, 1e-5),
               all_agree());
}

TEST_CASE("nests of nonsmooth functions move as the unsplit expression (fixed)") {
  const auto zone = [](double x, double half) { return x > half ? x - half : x < -half ? x + half : 0.0; };
  const std::vector<std::pair<std::string, std::function<double(double)>>> nests = {
      {"max(0.2, max(x, 0))", [](double x) { return std::max(0.2, std::max(x, 0.0)); }},
      {"max(max(x, 0), 0.2)", [](double x) { return std::max(std::max(x, 0.0), 0.2); }},
      {"max(0.2, 2*max(x, 0))", [](double x) { return std::max(0.2, 2.0 * std::max(x, 0.0)); }},
      {"max(0.2, abs(abs(x) - 0.1))", [](double x) { return std::max(0.2, std::abs(std::abs(x) - 0.1)); }},
      {"min(-0.2, -max(x, 0))", [](double x) { return std::min(-0.2, -std::max(x, 0.0)); }},
      {"max(0.2, deadzone(x, 0.3))", [&](double x) { return std::max(0.2, zone(x, 0.3)); }},
      {"0.3*sign(max(x, 0) - 0.2)", [](double x) { return std::max(x, 0.0) > 0.2 ? 0.3 : -0.3; }},
      {"0.3*step(max(x, 0) - 0.2)", [](double x) { return std::max(x, 0.0) > 0.2 ? 0.3 : 0.0; }},
      {"max(min(x, 0.2), max(2*abs(x) - 1, 0))*x",
       [](double x) { return std::max(std::min(x, 0.2), std::max(2.0 * std::abs(x) - 1.0, 0.0)) * x; }},
      {"clamp(abs(x), 0.1, max(0.5, x/2))", [](double x) { return std::clamp(std::abs(x), 0.1, std::max(0.5, 0.5 * x)); }}};
  for (const auto& one : nests) {
    const auto& text = one.first;
    const auto& force = one.second;
    INFO(text);
    const equations::TextSystem read = equations::make_system(forced(text).system);
    const Vector p = default_parameters(read.system.parameters);
    const double T = forcing_period(read.system, p);
    const Trajectory run = simulate(read.system, p, 0.0, vector({0.0, 0.3}), {.t_end = 2.0 * T});
    REQUIRE(run.termination == Termination::time);
    REQUIRE(!run.events.empty());
    // Fourth-order Runge-Kutta steps. A step over a corner has an error of third order, a step over a jump one of first order.
    constexpr int steps = 400000;
    const double h = 2.0 * T / steps;
    const auto rate = [&](double t, double x, double v) {
      return std::pair{v, p[1] * std::cos(p[0] * t) - 2.0 * p[2] * v - x - force(x)};
    };
    double x = 0.0, v = 0.3;
    for (int k = 0; k < steps; ++k) {
      const double t = k * h;
      const auto [x1, v1] = rate(t, x, v);
      const auto [x2, v2] = rate(t + 0.5 * h, x + 0.5 * h * x1, v + 0.5 * h * v1);
      const auto [x3, v3] = rate(t + 0.5 * h, x + 0.5 * h * x2, v + 0.5 * h * v2);
      const auto [x4, v4] = rate(t + h, x + h * x3, v + h * v3);
      x += h / 6.0 * (x1 + 2.0 * x2 + 2.0 * x3 + x4);
      v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
    }
    REQUIRE(std::abs(run.x[0] - x) < 1e-4);
    REQUIRE(std::abs(run.x[1] - v) < 1e-4);
  }
}

TEST_CASE("a reset to zero of one argument leaves the others their signs (fixed)") {
  SystemWriter writer;
  writer.states({"x", "v", "y", "w"}).forcing("eta").parameter("eta", "1").parameter("r", "0.2").parameter("e", "0");
  writer.mode("free", "x' = v; v' = -1 - 0.1*sign(v) + 0.2*cos(eta*t); y' = w; w' = 0.3*cos(eta*t) - 0.05*sign(w)");
  writer.event({"catch", "other", "x - r", "v = -e*v; w = w - 0.01", "", ""});
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = default_parameters(system.parameters), x = vector({0.0, 1.0, 0.0, 0.5});
  const Trajectory run = simulate(system, p, 0.0, x, {.t_end = 0.4});
  REQUIRE(run.termination == Termination::time);
  REQUIRE(run.events.size() == 1);
  REQUIRE(run.x[3] == Approx(0.49 + 0.3 * std::sin(0.4) - 0.05 * 0.4).epsilon(1e-11));
}
