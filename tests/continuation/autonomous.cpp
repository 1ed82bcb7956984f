// SPDX-License-Identifier: GPL-3.0-or-later
// Branches of autonomous orbits. Limit cycles of van der Pol's oscillator before a stop are compared with cycles from
// simulation. The branches pass grazings, period doublings and branch points.
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/orbit/mirror.hpp>
#include <graze/floquet/orbit/returns.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/system_texts.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace graze;
using namespace graze::support;

namespace {

/// Three states without impacts; a return is a crossing of y = 0 from below.
HybridSystem flow_in_space(const std::vector<std::pair<std::string, std::string>>& parameters, const std::string& equations) {
  SystemWriter writer;
  writer.states({"x", "y", "z"});
  for (const auto& [name, value] : parameters) writer.parameter(name, value);
  writer.mode("below", equations).mode("above", equations);
  writer.event({"up", "", "y", "", "below", "above"}).event({"down", "", "-y", "", "above", "below"});
  HybridSystem system = equations::make_system(writer.system).system;
  system.returns = {0};
  return system;
}

HybridSystem roessler() {
  return flow_in_space({{"a", "0.1"}, {"b", "0.1"}, {"c", "5"}}, "x' = -y - z\ny' = x + a*y\nz' = b + z*(x - c)");
}

/// The orbit on which motions settle.
PeriodicOrbit attracting(const HybridSystem& system, const Vector& p, const Vector& x) {
  const Attractor attractor = approach_attractor(system, p, x, {});
  REQUIRE(attractor.orbit);
  return at_nodes(*attractor.orbit->whole);
}

}  // namespace

TEST_CASE("autonomous orbits are continued with their durations") {
  const HybridSystem system = van_der_pol_stop();
  for (const auto& [name, to] : {std::pair("mu", 1.5), {"mu", 0.2}, {"k_r", 0.5}, {"r", 0.8}}) {
    INFO(name << " to " << to);
    const PeriodicOrbit orbit = shoot(system, parameters(system), std::vector<Vector>{vector({-1.5, 0.0})}, 1, {}, 5.0);
    REQUIRE(orbit.converged());
    REQUIRE(orbit.impacts == 1);
    ContinuationOptions options;
    options.parameter = name;
    options.to = to;
    const std::vector<Branch> branches = continue_orbit(system, orbit, options);
    REQUIRE(branches.size() == 1);
    CHECK(branches[0].stop == BranchStop::reached_bound);
    CHECK(check_branch(system, branches[0]) == std::vector<std::string>{});
    const BranchPoint& end = branches[0].points.back();
    CHECK(end.value == Approx(to));
    // From rest the motion settles on the cycle without Newton's method.
    const Vector p = parameters(system, {{name, to}});
    const Trajectory settled = simulate(system, p, 0.0, vector({0.5, 0.0}), {.t_end = 2000.0});
    const Trajectory to_impact = simulate(system, p, 0.0, settled.x, {.t_end = 50.0, .max_events = 1});
    const Trajectory round = simulate(system, p, 0.0, to_impact.x, {.t_end = 50.0, .max_events = 1});
    CHECK(end.duration == Approx(round.t).epsilon(1e-9));
    CHECK(std::abs(end.multipliers.values.front()) < 1.0);
  }
}

TEST_CASE("the cycle of van der Pol's oscillator gains and loses its impact where its amplitude is the distance of the stop") {
  const HybridSystem system = van_der_pol_stop();
  constexpr double amplitude = 2.0024879304471086;  // at mu = 0.5, by scipy's DOP853
  const Vector far = parameters(system, {{"r", 2.2}});
  const PeriodicOrbit free = shoot(system, far, std::vector<Vector>{vector({-1.5, 1.0})}, 1, {}, 6.4);
  REQUIRE(free.converged());
  REQUIRE(free.impacts == 0);
  ContinuationOptions options;
  options.parameter = "r";
  options.to = 1.8;
  const std::vector<Branch> in = continue_orbit(system, free, options);
  REQUIRE(in.size() == 2);
  REQUIRE(in[0].stop == BranchStop::grazing);
  const SpecialPoint& gained = in[0].special_points.back();
  CHECK(gained.value == Approx(amplitude).epsilon(1e-12));
  CHECK(std::get<std::vector<double>>(gained.details.at("impacts")) == std::vector<double>{0.0, 1.0});
  CHECK(text_detail(gained, "scenario") == "persistence");
  CHECK(in[1].parent->label == gained.label);
  CHECK(in[1].stop == BranchStop::reached_bound);
  CHECK(check_branch(system, in[1]) == std::vector<std::string>{});
  const BranchPoint& struck = in[1].points.back();
  CHECK(struck.impacts == 1);
  // The cycle with the impact, from simulation alone.
  const Vector p = parameters(system, {{"r", 1.8}});
  const Trajectory settled = simulate(system, p, 0.0, vector({0.5, 0.0}), {.t_end = 2000.0});
  const Trajectory to_impact = simulate(system, p, 0.0, settled.x, {.t_end = 50.0, .max_events = 1});
  const Trajectory round = simulate(system, p, 0.0, to_impact.x, {.t_end = 50.0, .max_events = 1});
  CHECK(struck.duration == Approx(round.t).epsilon(1e-9));

  const PeriodicOrbit near = shoot(system, p, std::vector<Vector>{struck.state()}, 1, {}, struck.duration);
  REQUIRE(near.impacts == 1);
  options.to = 2.2;
  const std::vector<Branch> out = continue_orbit(system, near, options);
  REQUIRE(out.size() == 2);
  CHECK(out[0].special_points.back().value == Approx(amplitude).epsilon(1e-12));
  CHECK(std::get<std::vector<double>>(out[0].special_points.back().details.at("impacts")) == std::vector<double>{1.0, 0.0});
  CHECK(out[1].stop == BranchStop::reached_bound);
  CHECK(out[1].points.back().duration == Approx(free.duration).epsilon(1e-10));
}

TEST_CASE("a doubled autonomous orbit is followed and attracts motions") {
  const HybridSystem system = roessler();
  const PeriodicOrbit orbit = attracting(system, parameters(system), vector({1.0, 1.0, 0.0}));
  ContinuationOptions options;
  options.parameter = "c";
  options.to = 6.0;
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  REQUIRE(branches.size() == 2);
  const auto doublings = points_of(branches[0], PointType::PD);
  REQUIRE(doublings.size() == 1);
  CHECK(text_detail(doublings[0], "criticality") == "supercritical");
  CHECK(branches[1].parent->label == doublings[0].label);
  CHECK(branches[1].period == 2);
  CHECK(branches[1].stop == BranchStop::reached_bound);
  CHECK(check_branch(system, branches[1]) == std::vector<std::string>{});
  CHECK(branches[1].points.front().duration == Approx(2.0 * doublings[0].orbit.duration).epsilon(1e-6));
  // After two returns.
  const Vector p = parameters(system, {{"c", 6.0}});
  const Attractor attractor = approach_attractor(system, p, vector({1.0, 1.0, 0.0}), {});
  REQUIRE(attractor.orbit);
  CHECK(attractor.orbit->period == 2);
  const BranchPoint& end = branches[1].points.back();
  CHECK(end.stable);
  CHECK(end.duration == Approx(attractor.orbit->duration).epsilon(1e-9));
  const PeriodicOrbit seed = at_nodes(*attractor.orbit->whole);
  CHECK(branch_contains(system, branches[1], seed.states, 6.0));
  CHECK(!branch_contains(system, branches[0], seed.states, 6.0));
  // From there the branch leads back, as one of period two.
  options.to = 5.0;
  const std::vector<Branch> back = continue_orbit(system, seed, options);
  CHECK(back[0].period == 2);
  CHECK(back[0].stop == BranchStop::returned);
  CHECK(std::abs(back[0].stop_value - doublings[0].value) < 1e-2);
}

TEST_CASE("both halves of a pitchfork of autonomous orbits are followed") {
  // On the unit circle z' = z (p + x/2 - z^2): the cycle z = 0 has the multiplier exp(2 pi p).
  const HybridSystem system =
      flow_in_space({{"p", "-0.2"}}, "x' = x*(1 - x^2 - y^2) - y\ny' = y*(1 - x^2 - y^2) + x\nz' = z*(p + x/2 - z^2)");
  const PeriodicOrbit orbit = shoot(system, parameters(system), std::vector<Vector>{vector({0.0, -1.0, 0.0})}, 1, {}, 6.2);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.parameter = "p";
  options.to = 0.3;
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  REQUIRE(branches.size() == 2);  // (x, y, z) -> (x, y, -z) maps one half to the other
  const auto crossings = points_of(branches[0], PointType::BP);
  REQUIRE(crossings.size() == 1);
  CHECK(std::abs(crossings[0].value) < 1e-12);
  CHECK(branches[1].parent->label == crossings[0].label);
  CHECK(branches[1].stop == BranchStop::reached_bound);
  REQUIRE(branches[1].mirrored);
  CHECK(symmetry_text(system, *branches[1].mirrored) == "(x, y, z)(t) -> (x, y, -z)(t)");
  CHECK(check_branch(system, branches[1]) == std::vector<std::string>{});
  // The mean of z'/z is zero, so that the mean of z^2 is p: the multiplier is exp(2 pi (p - 3 p)).
  for (const BranchPoint& point : branches[1].points)
    CHECK(point.multipliers.values.front().real() == Approx(std::exp(-4.0 * std::numbers::pi * point.value)).epsilon(1e-8));
}

TEST_CASE("where symmetry breaks without forcing, one of both mirror images is listed and names the other") {
  // Lorenz's equations have the symmetry (x, y, z) -> (-x, -y, z).
  const HybridSystem system = flow_in_space({{"sigma", "10"}, {"rho", "160"}, {"beta", "8/3"}},
                                            "x' = sigma*(y - x)\ny' = x*(rho - z) - y\nz' = x*y - beta*z");
  const Vector p = parameters(system);
  REQUIRE(symmetries(system, p).size() == 1);
  CHECK(symmetry_text(system, symmetries(system, p)[0]) == "(x, y, z)(t) -> (-x, -y, z)(t)");
  ContinuationOptions options;
  options.parameter = "rho";
  options.to = 150.0;
  options.max_multiple = 1;
  const PeriodicOrbit orbit = attracting(system, p, vector({1.0, 1.0, 150.0}));
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  const auto crossings = points_of(branches[0], PointType::BP);
  REQUIRE(crossings.size() == 1);
  const std::vector<const Branch*> broken = born_at(crossings[0], branches);
  REQUIRE(broken.size() == 1);
  REQUIRE(broken[0]->mirrored);
  CHECK(!branches[0].mirrored);
  // The orbit and its image attract, from starts that are images of each other.
  const Vector below = parameters(system, {{"rho", 151.0}});
  std::vector<PeriodicOrbit> pair;
  for (const double side : {1.0, -1.0}) pair.push_back(attracting(system, below, vector({side, side, 150.0})));
  CHECK(pair[0].duration == Approx(pair[1].duration).epsilon(1e-9));
  const std::vector<Vector> image = mirror_image(system, below, *broken[0]->mirrored, pair[0].nodes);
  int listed = 0;
  for (const PeriodicOrbit& one : pair) listed += branch_contains(system, *broken[0], one.nodes, 151.0);
  CHECK(listed == 1);
  CHECK(branch_contains(system, *broken[0], pair[0].nodes, 151.0) != branch_contains(system, *broken[0], image, 151.0));
}

TEST_CASE("a branch of autonomous orbits goes on where its first node would reach a stop (fixed)") {
  // Van der Pol's oscillator between two rigid stops.
  SystemWriter writer;
  writer.parameter("mu", "0.3");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {}, {{"1"}}, {"mu*(1 - x^2)*v"}});
  writer.stop("right", "0.7 - x", "newton", {"0.8"}).stop("left", "0.7 + x", "newton", {"0.8"});
  const HybridSystem system = equations::make_system(writer.system).system;
  for (const auto& [from, to] : {std::pair(0.3, 2.5), {1.0, 0.3}, {0.5, 1.5}}) {
    INFO(from << " to " << to);
    ContinuationOptions options;
    options.parameter = "mu";
    options.to = to;
    options.switch_generations = 0;
    const PeriodicOrbit orbit = attracting(system, parameters(system, {{"mu", from}}), vector({0.1, 0.5}));
    const std::vector<Branch> branches = continue_orbit(system, orbit, options);
    CHECK(branches[0].stop == BranchStop::reached_bound);
    CHECK(points_of(branches[0], PointType::MX).empty());
    const Trajectory settled = simulate(system, parameters(system, {{"mu", to}}), 0.0, vector({0.1, 0.5}), {.t_end = 400.0});
    const Trajectory round = simulate(system, parameters(system, {{"mu", to}}), 0.0, settled.x, {.t_end = 50.0, .max_events = 3});
    REQUIRE(round.events.size() == 3);
    CHECK(branches[0].points.back().duration == Approx(round.events[2].t - round.events[0].t).epsilon(1e-9));
  }
}

TEST_CASE("the doubled branch of an orbit that sticks in part is not taken for its parent (fixed)") {
  // A drill string with stick and slip; it pushes a second mass against a stop.
  SystemWriter writer;
  writer.system.name = "drill";
  writer.parameter("Om", "0.5").parameter("r", "0.66");
  writer.mechanics({"th", "z"}, {"w", "s"},
                   {{{"1", "0"}, {"0", "1.5"}}, {{"0.05", "0"}, {"0", "0.2"}}, {{"1", "0"}, {"0", "2"}}, {"0", "0.8*w + 0.3"}});
  writer.stop("top", "r - z", "newton", {"0.6"}).friction("bit", "w + Om", "1", "0.4 + 0.6*exp(-u/0.4)", "1");
  HybridSystem system = equations::make_system(writer.system).system;
  system.returns.clear();
  for (std::size_t e = 0; e < system.events.size(); ++e)
    if (system.events[e].kind == EventKind::stick) system.returns.push_back(e);
  const PeriodicOrbit orbit = attracting(system, default_parameters(system.parameters), vector({0.3, 0.0, 0.0, 0.0}));
  ContinuationOptions options;
  options.parameter = "r";
  options.from = 0.66;
  options.to = 0.69;
  options.switch_generations = 1;
  const BranchGraph graph = follow_branches(system, {{orbit, {1}}}, options);
  REQUIRE(graph.branches.size() == 2);
  REQUIRE(types_of(graph.branches[0]) == "PD");
  CHECK(std::abs(points_of(graph.branches[0], PointType::PD)[0].value - 0.67512445) < 1e-7);  // by shooting in another program
  CHECK(graph.branches[1].period == 2 * graph.branches[0].period);
  for (const Branch& branch : graph.branches) CHECK(check_branch(system, branch).empty());
}

TEST_CASE("a branch of autonomous orbits ends where they shrink to an equilibrium, at the Hopf point") {
  // Van der Pol's oscillator with a bias: the equilibrium x = a has the trace mu (1 - a^2).
  SystemWriter writer;
  writer.system.name = "biased";
  writer.parameter("mu", "0.5").parameter("a", "0");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0"}}, {{"1"}}, {"mu*(1-x^2)*v + a"}}).stop("right", "1.5 - x", "newton", {"0.6"});
  writer.system.stops.back().count = 1;
  const HybridSystem system = equations::make_system(writer.system).system;
  const PeriodicOrbit orbit = attracting(system, default_parameters(system.parameters), vector({0.5, 0.0}));
  for (const int direction : {1, -1}) {
    ContinuationOptions options;
    options.parameter = "a";
    options.from = -1.2;
    options.to = 1.2;
    const BranchGraph graph = follow_branches(system, {{orbit, {direction}}}, options);
    REQUIRE(!graph.branches.empty());
    for (const Branch& branch : graph.branches) CHECK(points_of(branch, PointType::BP).empty());
    const auto end = std::find_if(graph.branches.begin(), graph.branches.end(),
                                  [](const Branch& branch) { return branch.stop == BranchStop::equilibrium; });
    REQUIRE(end != graph.branches.end());
    CHECK(std::abs(end->stop_value - direction) < 1e-12);
    CHECK(end->points.back().multipliers.values[0].real() == Approx(1.0).margin(1e-3));  // of second order in the amplitude
  }
}
