// SPDX-License-Identifier: GPL-3.0-or-later
// Branches of orbits on which friction holds a mass all the time. It may be held anywhere in a band. The branch keeps the
// position at the start, and is then that of the other mass alone, with this position as a parameter.
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/pressed_mass.hpp"
#include "support/system_texts.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace graze;
using namespace graze::support;

namespace {

/// x1 is forced and may hit a stop; a spring k couples it to x2, on which the friction 0.5 N acts.
HybridSystem two_masses() {
  SystemWriter writer;
  writer.system.name = "two";
  writer.forcing("w").parameter("w", "0.9").parameter("F", "1").parameter("k", "0.5").parameter("N", "3").parameter("g", "0.4");
  writer.mechanics({"x1", "x2"}, {"v1", "v2"},
                   {{{"1", "0"}, {"0", "3"}}, {{"0.1", "0"}, {"0", "0.1"}}, {{"1+k", "-k"}, {"-k", "k"}}, {"F*cos(w*t)", "0"}});
  writer.stop("stop", "g - x1", "newton", {"0.7"}).friction("foot", "v2", "N", "0.3 + 0.1*exp(-u)", "0.5");
  return equations::make_system(writer.system).system;
}

/// The same with x2 as a parameter.
HybridSystem one_mass() {
  SystemWriter writer;
  writer.system.name = "one";
  writer.forcing("w").parameter("w", "0.9").parameter("F", "1").parameter("k", "0.5").parameter("g", "0.4").parameter("x2", "0");
  writer.mechanics({"x1"}, {"v1"}, {{{"1"}}, {{"0.1"}}, {{"1+k"}}, {"F*cos(w*t) + k*x2"}});
  writer.stop("stop", "g - x1", "newton", {"0.7"});
  return equations::make_system(writer.system).system;
}

PeriodicOrbit orbit_from(const HybridSystem& system, const Vector& p, const Vector& start) {
  const Settled settled = settle(system, p, start, {.periods = 200});
  REQUIRE(settled.termination == Termination::time);
  PeriodicOrbit orbit = shoot(system, p, settled.state, 1);
  REQUIRE(orbit.converged());
  return orbit;
}

struct Case {
  const char* parameter;
  double from, to, gap;
  int direction;
};

Branch followed(const HybridSystem& system, const PeriodicOrbit& orbit, const Case& one) {
  ContinuationOptions options;
  options.parameter = one.parameter;
  options.from = one.from;
  options.to = one.to;
  options.switch_generations = 0;
  const BranchGraph graph = follow_branches(system, {{orbit, {one.direction}}}, options);
  REQUIRE(!graph.branches.empty());
  return graph.branches.front();
}

/// The multipliers are those of the other mass, 0 for the held speed, and 1 for the held position.
void check_multipliers(const FloquetMultipliers& both, const FloquetMultipliers& alone) {
  REQUIRE(both.values.size() == 4);
  REQUIRE(alone.values.size() == 2);
  CHECK(both.trivial == 1);
  // A weak impact of speed s has a multiplier proportional to 1 / s: the error from rounding s is proportional to 1 / s^2.
  for (std::size_t i = 0; i < 2; ++i)
    CHECK(std::abs(both.values[i] - alone.values[i]) < std::max(1e-10, 1e-14 * std::norm(alone.values[i])));
  CHECK(both.values[2] == 0.0);
  CHECK(both.values[3] == 1.0);
}

}  // namespace

TEST_CASE("a branch on which friction holds one mass all the time is that of the other mass (fixed)") {
  const HybridSystem two = two_masses(), one = one_mass();
  // With impacts, in the coordinates of the events; and without, in states at fixed phases.
  for (const Case& row : std::vector<Case>{{"w", 0.9, 1.1, 0.4, 1},
                                           {"w", 0.6, 0.9, 0.4, -1},
                                           {"F", 1.0, 1.5, 0.4, 1},
                                           {"w", 0.9, 0.95, 50.0, 1},
                                           {"F", 1.0, 1.2, 50.0, 1}}) {
    constexpr double place = 0.1;
    INFO(row.parameter << " to " << (row.direction > 0 ? row.to : row.from) << ", gap " << row.gap);
    const PeriodicOrbit start = orbit_from(two, parameters(two, {{"g", row.gap}}), vector({0.0, place, 0.0, 0.0}));
    REQUIRE(start.state[3] == 0.0);
    const double held = start.state[1];
    const PeriodicOrbit alone =
        orbit_from(one, parameters(one, {{"g", row.gap}, {"x2", held}}), vector({start.state[0], start.state[2]}));
    const Branch both = followed(two, start, row), single = followed(one, alone, row);
    CHECK(both.stop == single.stop);
    CHECK(std::abs(both.stop_value - single.stop_value) < 1e-10);
    REQUIRE(both.points.size() > 5);
    REQUIRE(both.points.size() == single.points.size());
    for (std::size_t k = 0; k < both.points.size(); ++k) {
      const BranchPoint &b = both.points[k], &s = single.points[k];
      CHECK(std::abs(b.value - s.value) < 1e-10);
      CHECK(b.state()[1] == held);
      CHECK(b.state()[3] == 0.0);
      CHECK((vector({b.state()[0], b.state()[2]}) - s.state()).lpNorm<Eigen::Infinity>() < 1e-10);
      check_multipliers(b.multipliers, s.multipliers);
      CHECK(b.stable == s.stable);
      CHECK(b.impacts == s.impacts);
    }
    CHECK(types_of(both) == types_of(single));
    REQUIRE(both.special_points.size() == single.special_points.size());
    for (std::size_t k = 0; k < both.special_points.size(); ++k) {
      const SpecialPoint &b = both.special_points[k], &s = single.special_points[k];
      CHECK(std::abs(b.value - s.value) < 1e-10);
      if (b.type == PointType::GR) continue;  // its multipliers are singular
      check_multipliers(b.orbit.multipliers, s.orbit.multipliers);
    }
    CHECK(check_branch(two, both).empty());
  }
}

TEST_CASE("a branch on which friction holds two masses together is that of one mass") {
  // A block on a cart that is forced and hits a stop.
  SystemWriter writer;
  writer.system.name = "cart";
  writer.forcing("w").parameter("w", "0.9").parameter("F", "1").parameter("g", "0.4").parameter("N", "30");
  writer.mechanics({"x1", "x2"}, {"v1", "v2"},
                   {{{"0.7", "0"}, {"0", "0.3"}}, {{"0.1", "0"}, {"0", "0"}}, {{"1", "0"}, {"0", "0"}}, {"F*cos(w*t)", "0"}});
  writer.stop("stop", "g - x1", "linear", {"20", "0.5"}).friction("block", "v2 - v1", "N", "0.3 + 0.1*exp(-u)", "0.5");
  const HybridSystem cart = equations::make_system(writer.system).system;
  SystemWriter sum;
  sum.system.name = "one";
  sum.forcing("w").parameter("w", "0.9").parameter("F", "1").parameter("g", "0.4");
  sum.mechanics({"x1"}, {"v1"}, {{{"1"}}, {{"0.1"}}, {{"1"}}, {"F*cos(w*t)"}}).stop("stop", "g - x1", "linear", {"20", "0.5"});
  const HybridSystem one = equations::make_system(sum.system).system;
  for (const Case& row : std::vector<Case>{{"w", 0.9, 1.0, 0.4, 1}, {"F", 1.0, 1.3, 0.4, 1}, {"w", 0.5, 0.6, 50.0, -1}}) {
    INFO(row.parameter << " to " << (row.direction > 0 ? row.to : row.from) << ", gap " << row.gap);
    const auto at_start = [&](const HybridSystem& system) {
      return parameters(system, {{"g", row.gap}, {row.parameter, row.direction > 0 ? row.from : row.to}});
    };
    const PeriodicOrbit start = orbit_from(cart, at_start(cart), vector({0.0, 0.2, 0.0, 0.0}));
    const double distance = start.state[1] - start.state[0];
    const PeriodicOrbit alone = orbit_from(one, at_start(one), vector({start.state[0], start.state[2]}));
    const Branch both = followed(cart, start, row), single = followed(one, alone, row);
    CHECK(both.stop == single.stop);
    CHECK(std::abs(both.stop_value - single.stop_value) < 1e-9);
    REQUIRE(both.points.size() > 3);
    CHECK(types_of(both) == types_of(single));
    REQUIRE(both.special_points.size() == single.special_points.size());
    for (std::size_t k = 0; k < both.special_points.size(); ++k)
      CHECK(std::abs(both.special_points[k].value - single.special_points[k].value) < 1e-9);
    for (const BranchPoint& point : both.points) {
      CHECK(std::abs(point.state()[1] - point.state()[0] - distance) < 1e-9);
      CHECK(std::abs(point.state()[3] - point.state()[2]) < 1e-11);
      const Vector p = parameters(one, {{"g", row.gap}, {row.parameter, point.value}});
      const PeriodicOrbit there = shoot(one, p, vector({point.state()[0], point.state()[2]}), 1);
      REQUIRE(there.converged());
      CHECK((vector({point.state()[0], point.state()[2]}) - there.state).lpNorm<Eigen::Infinity>() < 1e-9);
      REQUIRE(point.multipliers.values.size() == 4);
      for (std::size_t i = 0; i < 2; ++i) CHECK(std::abs(point.multipliers.values[i] - there.multipliers.values[i]) < 1e-8);
      CHECK(point.multipliers.trivial == 1);
      CHECK(point.multipliers.values[2] == 0.0);
      CHECK(point.multipliers.values[3] == 1.0);
    }
  }
}

TEST_CASE("a branch on which friction holds a mass on a moving table is that of the other mass") {
  // The table moves by a cos(w t); the mass on it pulls the other one by a spring.
  SystemWriter writer;
  writer.system.name = "table";
  writer.forcing("w").parameter("w", "0.9").parameter("a", "0.3").parameter("k", "0.5").parameter("g", "0.3");
  writer.mechanics({"x1", "x2"}, {"v1", "v2"},
                   {{{"1", "0"}, {"0", "3"}}, {{"0.1", "0"}, {"0", "0"}}, {{"1+k", "-k"}, {"-k", "k"}}});
  writer.stop("stop", "g - x1", "newton", {"0.7"}).friction("foot", "v2 + a*w*sin(w*t)", "9", "0.5");
  const HybridSystem table = equations::make_system(writer.system).system;
  SystemWriter moved;
  moved.system.name = "moved";
  moved.forcing("w").parameter("w", "0.9").parameter("a", "0.3").parameter("k", "0.5").parameter("g", "0.3").parameter("d", "0");
  moved.mechanics({"x1"}, {"v1"}, {{{"1"}}, {{"0.1"}}, {{"1+k"}}, {"k*(d + a*cos(w*t))"}});
  moved.stop("stop", "g - x1", "newton", {"0.7"});
  const HybridSystem one = equations::make_system(moved.system).system;
  for (const Case& row : std::vector<Case>{{"w", 1.0, 1.1, 0.1, 1}, {"a", 0.3, 0.33, 0.1, 1}, {"a", 0.3, 0.5, 50.0, 1}}) {
    INFO(row.parameter << ", gap " << row.gap);
    const PeriodicOrbit start =
        orbit_from(table, parameters(table, {{"g", row.gap}, {row.parameter, row.from}}), vector({0.0, 0.4, 0.0, 0.0}));
    const Branch branch = followed(table, start, row);
    CHECK(branch.stop == BranchStop::reached_bound);
    REQUIRE(branch.points.size() > 3);
    for (const BranchPoint& point : branch.points) {
      // Its place on the table is one of many.
      const double amplitude = std::string(row.parameter) == "a" ? point.value : 0.3, place = point.state()[1] - amplitude;
      CHECK(std::abs(place - 0.1) < 0.3);
      const Vector p = parameters(one, {{"g", row.gap}, {"d", place}, {row.parameter, point.value}});
      const PeriodicOrbit there = shoot(one, p, vector({point.state()[0], point.state()[2]}), 1);
      REQUIRE(there.converged());
      CHECK((vector({point.state()[0], point.state()[2]}) - there.state).lpNorm<Eigen::Infinity>() < 1e-9);
      check_multipliers(point.multipliers, there.multipliers);
    }
  }
}

TEST_CASE("a branch on which friction holds one mass ends where the mass is released") {
  const HybridSystem two = two_masses();
  for (const double gap : {0.4, 50.0}) {
    INFO("gap " << gap);
    const Vector p = parameters(two, {{"g", gap}});
    const PeriodicOrbit start = orbit_from(two, p, vector({0.0, 0.0, 0.0, 0.0}));
    // The spring pulls with k |x1 - x2|; the friction holds up to 0.5 N.
    double largest = 0.0;
    Propagator propagator(two, p);
    Transition moved;
    constexpr int samples = 20000;
    for (int k = 1; k <= samples; ++k) {
      carry(propagator, 0.0, start.duration * k / samples, start.state, {.sensitivity = Sensitivity::none}, moved);
      largest = std::max(largest, std::abs(moved.x1[0] - start.state[1]));
    }
    const Branch branch = followed(two, start, {"N", 0.1, 3.0, gap, -1});
    CHECK(branch.stop == BranchStop::step_too_small);
    INFO(branch.message);
    CHECK(branch.message.find("is released there") != std::string::npos);
    CHECK(branch.stop_value > largest);
    CHECK(branch.stop_value < largest + 1e-6);
    CHECK(branch.special_points.back().type == PointType::MX);
  }
}

TEST_CASE("a capsule held all the time has a multiplier that is exactly zero at each point of its branch (fixed)") {
  // An inner mass at q in the capsule moves with speed y and drives it; friction of size 1 holds the capsule, u = 0.
  SystemWriter writer;
  writer.system.name = "capsule";
  writer.states({"q", "y", "u"}).forcing("w").parameter("w", "0.9");
  const std::string field = "q' = y - u; y' = 0.05*cos(w*t) - q - 0.1*(y - u); u' = (q + 0.1*(y - u) ";
  writer.mode("below", field + "+ 1)/4.9").mode("above", field + "- 1)/4.9").surface("u", "below", "above", "stick");
  const HybridSystem system = equations::make_system(writer.system).system;
  const PeriodicOrbit start = orbit_from(system, default_parameters(system.parameters), vector({0.0, 0.0, 0.0}));
  const Branch branch = followed(system, start, {"w", 0.9, 0.95, 0.0, 1});
  REQUIRE(branch.points.size() > 10);
  for (const BranchPoint& point : branch.points) {
    REQUIRE(point.multipliers.values.size() == 3);
    CHECK(point.multipliers.values[2] == 0.0);
    CHECK(point.multipliers.exponents[2] == -std::numeric_limits<double>::infinity());
    // The other two are those of q'' = -q - 0.1 q' over a forcing period: of modulus e^(-0.05 T).
    CHECK(std::abs(point.multipliers.values[0]) == Approx(std::exp(-0.05 * point.duration)).epsilon(1e-11));
  }
}

TEST_CASE("a branch of orbits held on a curved stop goes on at its usual steps (fixed)") {
  SystemWriter writer;
  writer.system.name = "ring";
  writer.forcing("w").parameter("w", "1.1").parameter("A", "0.2").parameter("R", "0.9");
  writer.mechanics(
      {"x", "y"}, {"v", "u"},
      {{{"1", "0"}, {"0", "2"}}, {{"0.2", "0"}, {"0", "0.2"}}, {{"1", "0"}, {"0", "1"}}, {"2 + A*cos(w*t)", "A*sin(w*t)"}});
  writer.stop("ring", "R^2 - x^2 - 1.5*y^2", "newton", {"0.5"});
  const HybridSystem system = equations::make_system(writer.system).system;
  const PeriodicOrbit start = orbit_from(system, default_parameters(system.parameters), vector({0.9, 0.0, 0.0, 0.0}));
  REQUIRE(start.events.empty());
  const Branch branch = followed(system, start, {"w", 1.0, 1.2, 0.0, 1});
  CHECK(branch.stop == BranchStop::reached_bound);
  INFO(branch.message);
  CHECK(branch.points.size() < 80);
  for (const BranchPoint& point : branch.points) {
    REQUIRE(point.multipliers.values.size() == 4);
    CHECK(point.multipliers.values[2] == 0.0);
    CHECK(point.multipliers.values[3] == 0.0);
    const Vector& x = point.states.front();
    CHECK(std::abs(0.81 - x[0] * x[0] - 1.5 * x[1] * x[1]) < 1e-12);
  }
  CHECK(check_branch(system, branch).empty());
}

TEST_CASE("a branch that cannot be begun again beyond a special point ends with what was found (fixed)") {
  // Static friction exceeds kinetic friction. Where the second mass begins to stick the orbit jumps; following it from there
  // crashed. Before, the branch folds (LP), and meets an NS.
  SystemWriter writer;
  writer.system.name = "pad";
  writer.forcing("w").parameter("w", "0.9").parameter("A", "1").parameter("mu", "0.25").parameter("N", "1");
  writer.mechanics(
      {"a", "b"}, {"va", "vb"},
      {{{"1", "0"}, {"0", "1.3"}}, {{"0.1", "-0.05"}, {"-0.05", "0.08"}}, {{"2", "-1"}, {"-1", "1.4"}}, {"A*cos(w*t)", "0"}});
  writer.friction("pad", "vb", "N*(1 + 0.3*a)", "mu", "1.3*mu");
  const HybridSystem system = equations::make_system(writer.system).system;
  const PeriodicOrbit start = orbit_from(system, default_parameters(system.parameters), vector({0.0, 0.0, 0.0, 0.0}));
  const Branch branch = followed(system, start, {"A", 0.15, 1.0, 0.0, -1});
  const auto found = [&](PointType type) {
    const auto point = std::find_if(branch.special_points.begin(), branch.special_points.end(),
                                    [&](const SpecialPoint& one) { return one.type == type; });
    return point == branch.special_points.end() ? 0.0 : point->value;
  };
  CHECK(found(PointType::LP) == Approx(0.373558215127).epsilon(1e-9));  // DOP853: multiplier 0.999999999 there
  CHECK(found(PointType::NS) == Approx(0.373664636298).epsilon(1e-9));  // modulus 1
  CHECK(branch.stop == BranchStop::step_too_small);
}

TEST_CASE("a branch on which a stop holds a mass all the time ends where the mass lifts off, and says so (fixed)") {
  // x is held at 1/2 by the force P - 1 + y - 0.1 y' > 0; y is a linear oscillator that feels x = 1/2.
  const HybridSystem system = equations::make_system(pressed_to("0.5 - x").system).system;
  const PeriodicOrbit start = orbit_from(system, default_parameters(system.parameters), vector({0.5, 0.0, 0.0, 0.0}));
  const Branch branch = followed(system, start, {"P", 0.0, 2.0, 0.0, -1});
  INFO(branch.message);
  CHECK(branch.message.find("is released there") != std::string::npos);
  // y = 1/2 + Re(Y e^(i w t)), Y = A / (1 - w^2 + 0.1 i w): the contact force P - 1 + y + 0.1 y' vanishes first at
  // P = 1/2 + |Y| |1 + 0.1 i w|.
  const double w = 0.8;
  const double lift_off = 0.5 + 0.3 / std::hypot(1.0 - w * w, 0.1 * w) * std::hypot(1.0, 0.1 * w);
  CHECK(std::abs(branch.stop_value - lift_off) < 1e-5);
}

TEST_CASE("where a release and the impact of another mass change places, a branch of orbits that rest goes on (fixed)") {
  // y is lifted off its seat and returns to it by complete chatter in each period; x hits its wall. Neither acts on the other.
  SystemWriter writer;
  writer.system.name = "apart";
  writer.forcing("eta").parameter("eta", "2.7");
  writer.mechanics({"y", "x"}, {"w", "v"},
                   {{{"1", "0"}, {"0", "1"}},
                    {{"0.2", "0"}, {"0", "0.05"}},
                    {{"0", "0"}, {"0", "1.1"}},
                    {"0.6 + cos(eta*t)", "cos(eta*t) + 0.1"}});
  writer.stop("wall", "-x", "newton", {"0.8"}).stop("seat", "1 - y", "newton", {"0.3"});
  const HybridSystem system = equations::make_system(writer.system).system;
  const PeriodicOrbit orbit = orbit_from(system, default_parameters(system.parameters), vector({0.2, -0.1, 0.0, 0.0}));
  CHECK(orbit.isolated_impacts == 1);
  ContinuationOptions options;
  options.parameter = "eta";
  options.from = 2.7;
  options.to = 3.15;
  const BranchGraph graph = follow_branches(system, {{orbit, {1}}}, options);
  REQUIRE(graph.branches.size() == 2);
  // The doubled branch passes the exchange near eta = 3.1235 and doubles again where the branch of x alone does.
  CHECK(graph.branches[1].parent);
  CHECK(graph.branches[1].stop == BranchStop::reached_bound);
  const auto doublings = points_of(graph.branches[1], PointType::PD);
  REQUIRE(doublings.size() == 1);
  SystemWriter alone;
  alone.system.name = "alone";
  alone.forcing("eta").parameter("eta", "2.7");
  alone.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.05"}}, {{"1.1"}}, {"cos(eta*t) + 0.1"}}).stop("wall", "-x", "newton", {"0.8"});
  const HybridSystem one = equations::make_system(alone.system).system;
  const BranchGraph of_one =
      follow_branches(one, {{orbit_from(one, default_parameters(one.parameters), vector({-0.1, 0.0})), {1}}}, options);
  REQUIRE(of_one.branches.size() >= 2);
  const auto exact = points_of(of_one.branches[1], PointType::PD);
  REQUIRE(!exact.empty());
  CHECK(std::abs(doublings[0].value - exact[0].value) < 1e-10);
}

namespace {

/// A forced mass on a belt of speed V, or on the floor with V = 0.
HybridSystem on_belt(const std::string& law, const std::string& w, const std::string& F) {
  SystemWriter writer;
  writer.system.name = "on belt";
  writer.forcing("w").parameter("w", w).parameter("F", F).parameter("V", "0").parameter("mu", "0.1");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{F == "1" ? "0.1" : "0.05"}}, {{"1"}}, {"F*cos(w*t)"}});
  writer.friction("belt", "v - V", "1", law);
  return equations::make_system(writer.system).system;
}

}  // namespace

TEST_CASE("with falling friction a branch goes on where its orbits begin to stick, over a jump of the multipliers") {
  const HybridSystem system = on_belt("0.4 + 0.4*exp(-3*u)", "1.3", "0.4");
  // The orbit that slides all the time touches the belt's speed at this V (DOP853 and Newton's method).
  constexpr double touches = 0.68861729034;
  for (const bool up : {true, false}) {
    const Vector p = parameters(system, {{"V", up ? 0.6 : 0.7}});
    const PeriodicOrbit orbit =
        shoot(system, p, up ? settle(system, p, vector({0.0, 0.0})).state : vector({0.02075, -0.2066}), 1);
    REQUIRE(orbit.converged());
    const Branch branch = followed(system, orbit, {"V", 0.55, 0.8, 0.0, up ? 1 : -1});
    CHECK(branch.stop == BranchStop::reached_bound);
    const auto grazings = points_of(branch, PointType::GR);
    REQUIRE(grazings.size() == 1);
    CHECK(text_detail(grazings[0], "kind") == "sliding");
    CHECK(text_detail(grazings[0], "scenario") == "persistence");
    CHECK(std::abs(grazings[0].value - touches) < 1e-8);
    CHECK(grazings[0].precision < 1e-7);
    for (const BranchPoint& point : branch.points) {
      INFO("V " << point.value);
      const bool sticks = point.value <= grazings[0].interval[0];
      CHECK((sticks || point.value >= grazings[0].interval[1]));
      CHECK(point.stable == sticks);
      CHECK((point.multipliers.values[1] == 0.0) == sticks);
    }
  }
}

TEST_CASE("where friction begins to hold a mass for good its place is kept, and no branch point is found") {
  // The largest force is 1: friction holds the mass for good from mu = 1 on, first at x = 0 alone.
  const HybridSystem system = on_belt("mu", "0.6", "1");
  const Vector p = parameters(system, {{"mu", 0.9}});
  const PeriodicOrbit orbit = orbit_from(system, p, vector({0.5, 0.0}));
  const Branch branch = followed(system, orbit, {"mu", 0.9, 1.2, 0.0, 1});
  CHECK(branch.stop == BranchStop::reached_bound);
  CHECK(points_of(branch, PointType::BP).empty());
  const auto grazings = points_of(branch, PointType::GR);
  REQUIRE(!grazings.empty());
  CHECK(text_detail(grazings.back(), "kind") == "sliding");
  CHECK(grazings.back().interval[0] < 1.0 + 1e-12);
  CHECK(grazings.back().interval[1] > 1.0 - 1e-12);
  CHECK(grazings.back().precision < 1e-2);  // the branch may follow the edge of the places that are held
  const BranchPoint& end = branch.points.back();
  for (const BranchPoint& point : branch.points)
    if (point.value > grazings.back().interval[1] + 1e-12) {
      CHECK(point.state()[0] == end.state()[0]);
      CHECK(point.multipliers.trivial == 1);
    }
}
