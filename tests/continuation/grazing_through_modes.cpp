// SPDX-License-Identifier: GPL-3.0-or-later
// Grazings of contacts that pass through other modes. A mass that is pressed against a stop lifts off: a spring with a damper,
// and a rigid stop on which friction holds the mass. The references are closed forms, and values from scipy's DOP853 with
// separately written equations.
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <catch2/catch.hpp>

#include <cmath>
#include <complex>
#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

using Impacts = std::vector<double>;

Impacts impacts_at(const SpecialPoint& grazing) { return std::get<Impacts>(grazing.details.at("impacts")); }

/// x'' + 2 b x' + x = A cos(eta t) + P - (k x + c x') while the pad presses and x > 0.
struct Pad {
  double b = 0.1, P = 1.2, k = 2.0, c = 0.0, eta = 0.8;

  HybridSystem system() const {
    SystemWriter writer;
    writer.forcing("eta");
    for (const auto& [name, value] : {std::pair("b", b), {"P", P}, {"k", k}, {"c", c}, {"eta", eta}, {"A", 0.5}})
      writer.parameter(name, fmt::format("{}", value));
    writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"2*b"}}, {{"1"}}, {"A*cos(eta*t) + P"}});
    writer.stop("pad", "-x", "linear", c > 0.0 ? std::vector<std::string>{"k", "c"} : std::vector<std::string>{"k"});
    return equations::make_system(writer.system).system;
  }

  /// Always pressed, x = P/(1 + k) + Re(X e^(i eta t)) with X proportional to A.
  std::complex<double> response() const { return 1.0 / std::complex<double>(1.0 + k - eta * eta, eta * (2.0 * b + c)); }
  PeriodicOrbit pressed(const HybridSystem& system, double A) const {
    const std::complex<double> X = A * response();
    return shoot(system, parameters(system, {{"A", A}}), vector({P / (1.0 + k) + X.real(), -eta * X.imag()}), 1);
  }
  /// The contact force k x + c x' first vanishes where its amplitude equals its mean.
  double lift_off() const { return k * P / (1.0 + k) / std::abs(response() * std::complex<double>(k, c * eta)); }

  /// The motion from x over a forcing period, by a Runge-Kutta method without events.
  Vector period_of(const Vector& x, double A) const {
    constexpr int steps = 200000;
    const auto f = [&](double t, const Vector& y) {
      const double force = y[0] > 0.0 ? std::max(0.0, k * y[0] + c * y[1]) : 0.0;
      return vector({y[1], A * std::cos(eta * t) + P - 2.0 * b * y[1] - y[0] - force});
    };
    const double h = 2.0 * std::numbers::pi / eta / steps;
    Vector y = x;
    for (int i = 0; i < steps; ++i) {
      const double t = i * h;
      const Vector k1 = f(t, y), k2 = f(t + 0.5 * h, y + 0.5 * h * k1), k3 = f(t + 0.5 * h, y + 0.5 * h * k2),
                   k4 = f(t + h, y + h * k3);
      y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return y;
  }
};

ContinuationOptions options_in(const std::string& parameter, double to) {
  ContinuationOptions options;
  options.parameter = parameter;
  options.to = to;
  options.switch_generations = 0;
  return options;
}

/// The orbit on which the motion from x settles.
PeriodicOrbit settled(const HybridSystem& system, const Vector& p, const Vector& x) {
  const double T = forcing_period(system, p);
  const Trajectory motion = simulate(system, p, 0.0, x, {.t_end = 200.0 * T});
  return shoot(system, p, motion.x, 1);
}

}  // namespace

TEST_CASE("a mass pressed against a spring lifts off where its amplitude is the static deflection") {
  for (const Pad& pad : {Pad{}, Pad{.b = 0.05, .P = 0.4, .k = 30.0, .eta = 1.7}}) {
    const HybridSystem system = pad.system();
    const double exact = pad.lift_off();
    INFO("lifts off at A = " << exact);
    const PeriodicOrbit orbit = pad.pressed(system, 0.5 * exact);
    REQUIRE(orbit.converged());
    REQUIRE(orbit.events.empty());
    const std::vector<Branch> up = continue_orbit(system, orbit, options_in("A", 1.2 * exact));
    REQUIRE(up.size() == 1);
    CHECK(up[0].stop == BranchStop::reached_bound);
    CHECK(check_branch(system, up[0]) == std::vector<std::string>{});
    const auto grazings = points_of(up[0], PointType::GR);
    REQUIRE(!grazings.empty());
    CHECK(grazings[0].status == PointStatus::converged);
    CHECK(std::abs(grazings[0].value - exact) < 1e-12 * exact);
    CHECK(text_detail(grazings[0], "scenario") == "smooth");
    CHECK(impacts_at(grazings[0]) == Impacts{0.0, 1.0});
    const BranchPoint& beyond = up[0].points.at(grazings[0].after_point + 2);
    CHECK(beyond.impacts == 1);
    CHECK((pad.period_of(beyond.state(), beyond.value) - beyond.state()).lpNorm<Eigen::Infinity>() < 1e-8);
  }
}

TEST_CASE("a mass pressed against a spring with a damper lifts off where its force first vanishes") {
  const Pad pad{.c = 0.3};
  const HybridSystem system = pad.system();
  const double exact = pad.lift_off();
  const std::vector<Branch> up = continue_orbit(system, pad.pressed(system, 0.5), options_in("A", 1.5));
  REQUIRE(up.size() == 2);
  REQUIRE(up[0].stop == BranchStop::grazing);
  const SpecialPoint& grazing = up[0].special_points.back();
  CHECK(std::abs(grazing.value - exact) < 1e-12);
  CHECK(text_detail(grazing, "scenario") == "smooth");
  CHECK(impacts_at(grazing) == Impacts{0.0, 1.0});
  CHECK(up[1].parent->label == grazing.label);
  CHECK(up[1].stop == BranchStop::reached_bound);
  CHECK(up[1].points.front().impacts == 1);
  CHECK(std::abs(up[1].points.front().value - exact) < 1e-5);
  // The branch also continues beyond the opening of the gap: from there the contact begins with a jump of the force.
  const BranchPoint& end = up[1].points.back();
  CHECK((pad.period_of(end.state(), end.value) - end.state()).lpNorm<Eigen::Infinity>() < 1e-5);
  const Vector p = parameters(system, {{"A", end.value}});
  const std::vector<Branch> down = continue_orbit(system, settled(system, p, end.state()), options_in("A", 0.5));
  REQUIRE(down.size() == 2);
  CHECK(std::abs(down[0].special_points.back().value - exact) < 1e-12);
  CHECK(impacts_at(down[0].special_points.back()) == Impacts{1.0, 0.0});
  CHECK(down[1].stop == BranchStop::reached_bound);
  CHECK(down[1].points.back().state().isApprox(pad.pressed(system, 0.5).state, 1e-9));
}

TEST_CASE("a rotor in rubbing contact with a ring lifts off") {
  SystemWriter writer;
  writer.states({"x", "y", "vx", "vy"}).forcing("eta");
  writer.parameter("b", "0.05").parameter("eps", "0.6").parameter("eta", "1").parameter("k", "30").parameter("s", "0.1");
  writer.definition("rho", "sqrt(x^2 + y^2)");
  writer.definition("ax", "eps*eta^2*cos(eta*t) - 2*b*vx - x + s").definition("ay", "eps*eta^2*sin(eta*t) - 2*b*vy - y");
  writer.mode("free", "x' = vx\ny' = vy\nvx' = ax\nvy' = ay");
  writer.mode("rub", "x' = vx\ny' = vy\nvx' = ax - k*(rho - 1)*x/rho\nvy' = ay - k*(rho - 1)*y/rho");
  writer.event({"touch", "enter", "rho - 1", "", "free", "rub"});
  writer.event({"part", "leave", "1 - rho", "", "rub", "free"});
  const HybridSystem system = equations::make_system(writer.system).system;
  CHECK(!has_hard_contacts(system));
  const PeriodicOrbit orbit = settled(system, parameters(system), vector({1.02, -0.176, 0.2047, 1.1807}));
  REQUIRE(orbit.converged());
  REQUIRE(orbit.events.empty());
  const std::vector<Branch> branches = continue_orbit(system, orbit, options_in("eta", 0.93));
  REQUIRE(branches.size() == 1);
  CHECK(branches[0].stop == BranchStop::reached_bound);
  const auto grazings = points_of(branches[0], PointType::GR);
  REQUIRE(!grazings.empty());
  CHECK(grazings[0].value == Approx(0.9403115847588654).epsilon(1e-12));
  CHECK(impacts_at(grazings[0]) == Impacts{0.0, 1.0});
}

TEST_CASE("a weak contact with a spring and a damper is lost and the branch continues without it") {
  SystemWriter writer;
  writer.forcing("w").parameter("w", "0.9").parameter("A", "0.9").parameter("k", "25").parameter("c", "3");
  writer.parameter("kH", "40").parameter("bH", "0.15");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.1"}}, {{"1"}}, {"A*cos(w*t)"}});
  writer.stop("kv", "0.6 - x", "linear", {"k", "c"}).stop("hz", "0.8 + x", "hertz", {"kH", "bH"});
  const HybridSystem system = equations::make_system(writer.system).system;
  constexpr double exact = 0.9086694690876557;
  const PeriodicOrbit with_contact = settled(system, parameters(system), vector({0.4936, -0.0845}));
  REQUIRE(with_contact.impacts == 3);
  const std::vector<Branch> up = continue_orbit(system, with_contact, options_in("w", 1.0));
  REQUIRE(up.size() == 2);
  REQUIRE(up[0].stop == BranchStop::grazing);
  const SpecialPoint& grazing = up[0].special_points.back();
  CHECK(grazing.value == Approx(exact).epsilon(1e-12));
  CHECK(impacts_at(grazing) == Impacts{3.0, 2.0});
  CHECK(text_detail(grazing, "scenario") == "persistence");
  CHECK(grazing.touching.size() == 3);  // enter, leave, open
  CHECK(up[1].points.front().impacts == 2);
  CHECK(up[1].stop == BranchStop::reached_bound);
  const PeriodicOrbit without = settled(system, parameters(system, {{"w", 0.95}}), up[1].points.back().state());
  REQUIRE(without.impacts == 2);
  const std::vector<Branch> down = continue_orbit(system, without, options_in("w", 0.9));
  REQUIRE(down.size() == 2);
  CHECK(down[0].special_points.back().value == Approx(exact).epsilon(1e-12));
  CHECK(impacts_at(down[0].special_points.back()) == Impacts{2.0, 3.0});
  CHECK(text_detail(down[0].special_points.back(), "scenario") == "persistence");
  CHECK(down[1].points.front().impacts == 3);
  CHECK(down[1].stop == BranchStop::reached_bound);
  CHECK(down[1].points.back().state().isApprox(with_contact.state, 1e-8));
  // In the other direction one impact is lost and another one gained.
  const std::vector<Branch> on = continue_orbit(system, with_contact, options_in("w", 0.5));
  REQUIRE(on.size() == 3);
  CHECK(impacts_at(on[0].special_points.back()) == Impacts{3.0, 2.0});
  CHECK(impacts_at(on[1].special_points.back()) == Impacts{2.0, 3.0});
  CHECK(on[2].stop == BranchStop::reached_bound);
}

TEST_CASE("a mass held by friction as it touches a rigid stop gains an impact there") {
  SystemWriter writer;
  writer.forcing("om").parameter("om", "0.5").parameter("F", "1.3").parameter("mu", "0.3").parameter("ms", "0.4");
  writer.parameter("vs", "0.5").parameter("N", "1.1").parameter("r", "1").parameter("e", "0.7");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.02"}}, {{"1"}}, {"F*cos(om*t)"}});
  writer.stop("wall", "r - x", "newton", {"e"});
  writer.friction("slide", "v", "N", "mu + (ms - mu)*exp(-(u/vs)^2)", "ms");
  const HybridSystem system = equations::make_system(writer.system).system;
  constexpr double exact = 1.337358315119029;
  const PeriodicOrbit once = settled(system, parameters(system), vector({0.705, 0.135}));
  REQUIRE(once.impacts == 1);
  const std::vector<Branch> up = continue_orbit(system, once, options_in("F", 1.4));
  REQUIRE(up.size() == 2);
  REQUIRE(up[0].stop == BranchStop::grazing);
  CHECK(up[0].special_points.back().value == Approx(exact).epsilon(1e-12));
  CHECK(impacts_at(up[0].special_points.back()) == Impacts{1.0, 2.0});
  CHECK(text_detail(up[0].special_points.back(), "scenario") == "persistence");
  CHECK(up[1].points.front().impacts == 2);
  CHECK(up[1].stop == BranchStop::reached_bound);
  const PeriodicOrbit twice = settled(system, parameters(system, {{"F", 1.4}}), up[1].points.back().state());
  REQUIRE(twice.impacts == 2);
  const std::vector<Branch> down = continue_orbit(system, twice, options_in("F", 1.3));
  REQUIRE(down.size() == 2);
  CHECK(down[0].special_points.back().value == Approx(exact).epsilon(1e-12));
  CHECK(impacts_at(down[0].special_points.back()) == Impacts{2.0, 1.0});
  CHECK(down[1].points.back().state().isApprox(once.state, 1e-8));
}

TEST_CASE("an impact begins at its grazing where drag changes its sign at the touch") {
  SystemWriter writer;
  writer.states({"x", "v"}).forcing("w");
  writer.parameter("A", "1.3").parameter("w", "0.9").parameter("r", "0.6").parameter("e", "0.7");
  writer.mode("m", "x' = v\nv' = A*cos(w*t) - 0.1*v*abs(v) - x").event({"h", "impact", "x - r", "v = -e*v", "", ""});
  const HybridSystem system = equations::make_system(writer.system).system;
  const PeriodicOrbit once = settled(system, parameters(system), vector({0.4649, -1.6085}));
  REQUIRE(once.impacts == 1);
  const std::vector<Branch> branches = continue_orbit(system, once, options_in("w", 0.75));
  REQUIRE(branches.size() == 2);
  REQUIRE(branches[0].stop == BranchStop::grazing);
  CHECK(impacts_at(branches[0].special_points.back()) == Impacts{1.0, 2.0});
  CHECK(text_detail(branches[0].special_points.back(), "scenario") == "nonsmooth-fold");
  CHECK(branches[1].points.front().impacts == 2);
  CHECK(branches[1].points.front().value > branches[0].special_points.back().value);
  CHECK(branches[1].stop == BranchStop::reached_bound);
}

TEST_CASE("a branch of orbits held by friction ends where the mass first slides and does not jump to sliding orbits") {
  SystemWriter writer;
  writer.forcing("om")
      .parameter("om", "0.5")
      .parameter("F", "0.3")
      .parameter("mu", "0.3")
      .parameter("ms", "0.4")
      .parameter("N", "1.1");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.02"}}, {{"1"}}, {"F*cos(om*t)"}});
  writer.friction("slide", "v", "N", "mu", "ms");
  const HybridSystem system = equations::make_system(writer.system).system;
  const PeriodicOrbit held = shoot(system, parameters(system), vector({0.0, 0.0}), 1);
  REQUIRE(held.converged());
  const std::vector<Branch> branches = continue_orbit(system, held, options_in("F", 0.7));
  REQUIRE(branches.size() == 1);
  CHECK(branches[0].stop == BranchStop::step_too_small);
  CHECK(branches[0].stop_value == Approx(0.4 * 1.1).epsilon(1e-8));  // ms N
  for (const BranchPoint& point : branches[0].points) CHECK(point.state().norm() < 1e-6);
}

TEST_CASE("an impact that starts a slip begins at its grazing in COCO's stick-slip example") {
  SystemWriter writer;
  writer.states({"q", "v", "u"});
  writer.system.period = writer.write("pi/w");
  writer.parameter("V", "0.55").parameter("c", "0.04").parameter("n", "3.17").parameter("w", "0.92").parameter("e", "0.8");
  writer.definition("F", "V^2*sin(w*t)^2/(1 - q)^2 - c*v - q");
  writer.mode("stick", "q' = v\nv' = F\nu' = 0").mode("slip", "q' = v\nv' = n + 6*F/5\nu' = -n - F/5");
  writer.event({"collision", "impact", "q - 0.5", "v = -e*v; u = (1 + e)/6*v", "stick", "slip"});
  writer.event({"rest", "stick", "-u", "u = 0", "slip", "stick"});
  const HybridSystem system = equations::make_system(writer.system).system;
  constexpr double exact = 0.587516250415465;
  // The orbit without collisions passes a fold on its way to the grazing and therefore meets it from the other side.
  const PeriodicOrbit struck = shoot(system, parameters(system, {{"V", 0.65}}), vector({0.49339, -0.10227, 0.0}), 1);
  REQUIRE(struck.converged());
  REQUIRE(struck.impacts == 1);
  const std::vector<Branch> down = continue_orbit(system, struck, options_in("V", 0.5));
  REQUIRE(down.size() == 2);
  CHECK(down[0].special_points.back().value == Approx(exact).epsilon(1e-12));
  CHECK(text_detail(down[0].special_points.back(), "scenario") == "nonsmooth-fold");
  CHECK(down[1].points.front().impacts == 0);
  CHECK(down[1].points.front().value > exact);
  CHECK(down[1].stop == BranchStop::reached_bound);
  const BranchPoint& free = down[1].points.back();
  const PeriodicOrbit unstruck = shoot(system, parameters(system, {{"V", free.value}}), free.state(), 1);
  REQUIRE(unstruck.converged());
  const std::vector<Branch> up = continue_orbit(system, unstruck, options_in("V", 0.65));
  REQUIRE(up.size() == 2);
  CHECK(up[0].special_points.back().value == Approx(exact).epsilon(1e-12));
  CHECK(impacts_at(up[0].special_points.back()) == Impacts{0.0, 1.0});
  CHECK(up[1].points.front().impacts == 1);
  CHECK(up[1].points.front().value > exact);
  CHECK(up[1].points.back().value == Approx(0.65));
  CHECK(up[1].points.back().state().isApprox(struck.state, 1e-8));
}
