// SPDX-License-Identifier: GPL-3.0-or-later
// Kinks of branches: the multipliers jump, but no impact is gained or lost. Two masses, one of which moves between two stops with
// dampers, and a mass with friction before a stop. The values beside a kink are those of an independent program (DOP853 with
// events, differences for the multipliers).
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/system_texts.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

/// The second mass moves between two stops with dampers.
HybridSystem between_stops() {
  SystemWriter writer;
  writer.system.name = "between stops";
  writer.forcing("w").parameter("w", "0.75").parameter("g", "0.6");
  writer.mechanics(
      {"x2", "x1"}, {"v2", "v1"},
      {{{"1.5", "0"}, {"0", "1"}}, {{"0.06", "0.06"}, {"0.06", "0.12"}}, {{"0.8", "0.8"}, {"0.8", "1.8"}}, {"-cos(w*t)", "0"}});
  writer.stop("L", "g + x1", "linear", {"20", "0.3"}).stop("R", "g - x1", "linear", {"20", "0.3"});
  return equations::make_system(writer.system).system;
}

/// A mass with dry friction, before a stop with these stiffness and damping if it has one.
HybridSystem with_friction(const std::string& w, const std::string& F, const std::string& c, const std::string& law,
                           const std::vector<std::string>& stop) {
  SystemWriter writer;
  writer.system.name = "with friction";
  writer.forcing("w").parameter("w", w).parameter("mu", "0.3");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{c}}, {{"1"}}, {F + "*cos(w*t)"}});
  if (!stop.empty()) writer.stop("wall", "1 - x", "linear", stop);
  writer.friction("floor", "v", "1", law);
  return equations::make_system(writer.system).system;
}

std::vector<Branch> followed(const HybridSystem& system, const PeriodicOrbit& orbit, const char* parameter, double from,
                             double to, int branches = 1) {
  ContinuationOptions options;
  options.parameter = parameter;
  options.from = from;
  options.to = to;
  options.max_branches = branches;
  options.switch_generations = 0;
  return continue_orbit(system, orbit, options);
}

}  // namespace

TEST_CASE("where a stop that has let go is met before the mass has left it the branch goes on over a kink (fixed)") {
  const HybridSystem system = between_stops();
  const PeriodicOrbit orbit = shoot(system, parameters(system, {{"w", 0.7505}}), vector({5.5942, -0.7233, -1.4007, -1.51237}), 1);
  REQUIRE(orbit.converged());
  const Branch branch = followed(system, orbit, "w", 0.7505, 0.76).front();
  const auto grazings = points_of(branch, PointType::GR);
  REQUIRE(grazings.size() == 2);
  CHECK(text_detail(grazings[0], "kind") == "contact");
  CHECK(text_detail(grazings[0], "scenario") == "persistence");
  CHECK(std::abs(grazings[0].value - 0.75091649558) < 1e-10);
  CHECK(grazings[0].orbit.admissible == Admissibility::admissible);
  CHECK(text_detail(grazings[1], "kind") == "lost");
  CHECK(std::abs(grazings[1].value - 0.751175126353) < 1e-11);
  // -3.3722959 at 0.75091649 and -3.4304918 at 0.75092; before the kink with the root of the distance.
  for (const BranchPoint& point : branch.points) {
    if (std::abs(point.value - grazings[0].value) > 1e-5) continue;
    INFO("w " << point.value);
    const double mu = point.multipliers.values[0].real();
    const bool beyond = point.value >= grazings[0].interval[1];
    CHECK((beyond ? mu < -3.425 : mu > -3.39));
    CHECK((beyond ? mu > -3.433 : mu < -3.3719));
  }
}

TEST_CASE("a branch does not turn back along itself where a kink lies close behind its grazing (fixed)") {
  const HybridSystem system = between_stops();
  const PeriodicOrbit orbit = shoot(system, parameters(system), vector({5.6618943, -0.7443883, -1.4377173, -1.5268018}), 1);
  REQUIRE(orbit.converged());
  const Branch branch = followed(system, orbit, "w", 0.75, 1.6).front();
  CHECK(branch.stop == BranchStop::grazing);
  CHECK(std::abs(branch.stop_value - 0.751175126353) < 1e-11);
  for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) CHECK(branch.points[i].value <= branch.points[i + 1].value + 1e-12);
  for (const SpecialPoint& point : points_of(branch, PointType::GR)) CHECK(text_detail(point, "scenario") != "nonsmooth-fold");
}

TEST_CASE("a contact in which friction stops the mass begins and ends at one grazing, whichever side it is met from (fixed)") {
  const HybridSystem system = with_friction("0.8", "1.5", "0.05", "mu", {"30", "1.5"});
  constexpr double grazing = 1.24776435988;
  for (const auto& [from, to] : {std::pair(1.2, 1.3), std::pair(1.3, 1.2)}) {
    INFO("from " << from);
    const Vector p = parameters(system, {{"mu", from}});
    const PeriodicOrbit orbit = shoot(system, p, settle(system, p, vector({0.0, 0.0})).state, 1);
    REQUIRE(orbit.converged());
    const std::vector<Branch> branches = followed(system, orbit, "mu", from, to, 4);
    REQUIRE(branches.size() == 2);
    CHECK(branches[0].stop == BranchStop::grazing);
    CHECK(std::abs(branches[0].stop_value - grazing) < 1e-10);
    CHECK(text_detail(points_of(branches[0], PointType::GR).back(), "scenario") == "persistence");
    CHECK(branches[1].stop == BranchStop::reached_bound);
    CHECK(branches[1].stop_value == to);
  }
}

TEST_CASE("a stop whose forces are of order 1e-6 has no weaker impacts (fixed)") {
  SystemWriter writer;
  writer.system.name = "small forces";
  writer.forcing("w").parameter("w", "0.508");
  writer.mechanics({"x"}, {"v"}, {{{"1e-6"}}, {{"4e-8"}}, {{"1e-6"}}, {"1e-6*cos(w*t)"}});
  writer.stop("right", "0.9 - x", "linear", {"3e-5", "5e-7"}).friction("floor", "v", "8e-8", "1");
  const HybridSystem system = equations::make_system(writer.system).system;
  const Vector p = parameters(system, {{"w", 0.508}});
  const PeriodicOrbit orbit = shoot(system, p, vector({0.705, 0.036}), 1);
  REQUIRE(orbit.converged());
  REQUIRE(orbit.impacts == 2);
  const std::vector<Branch> branches = followed(system, orbit, "w", 0.508, 0.5, 2);
  REQUIRE(branches.size() == 2);
  CHECK(std::abs(branches[0].stop_value - 0.506731530184) < 1e-11);
  CHECK(branches[1].stop == BranchStop::reached_bound);
  CHECK(branches[1].points.back().value == 0.5);
  CHECK(branches[1].points.size() > 5);
}
