// SPDX-License-Identifier: GPL-3.0-or-later
// Neimark-Sacker points, which need four states, branch points, which need a symmetry, and double multipliers.
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/attractor.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/driven_self_excited.hpp"
#include "support/system_texts.hpp"
#include "support/two_sided_oscillator.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

Eigen::Index index(const HybridSystem& system, const char* name) {
  return static_cast<Eigen::Index>(parameter_index(system.parameters, name));
}

}  // namespace

TEST_CASE("a Neimark-Sacker point of an impacting system with four states agrees with its closed form") {
  const HybridSystem system = driven_self_excited();
  Vector p = default_parameters(system.parameters);
  p[index(system, "epsilon")] = 0.0;
  p[index(system, "mu")] = -0.1;
  const PeriodicOrbit orbit = shoot(system, p, settle(system, p, Vector::Zero(4), {.periods = 300}).state, 1);
  REQUIRE(orbit.converged());
  REQUIRE(orbit.impacts == 1);
  ContinuationOptions options;
  options.parameter = "mu";
  options.to = 0.1;
  options.switch_generations = 0;
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  REQUIRE(branches.size() == 1);
  const auto points = points_of(branches[0], PointType::NS);
  REQUIRE(points.size() == 1);
  CHECK(points[0].status == PointStatus::converged);
  CHECK(std::abs(points[0].value) < 1e-12);  // |multiplier| = exp(mu T/2)
  // Its angle is omega T, reduced to [0, pi].
  const double turn = p[index(system, "omega")] * forcing_period(system, p);
  CHECK(std::cos(std::get<double>(points[0].details.at("angle"))) == Approx(std::cos(turn)).margin(1e-10));
  for (const PointType type : {PointType::LP, PointType::PD, PointType::BP}) CHECK(points_of(branches[0], type).empty());
  CHECK(check_branch(system, branches[0]).empty());
}

TEST_CASE("a symmetric orbit between two elastic stops loses its symmetry in a branch point") {
  const HybridSystem system = two_sided_oscillator(false);
  Vector p = default_parameters(system.parameters);
  p[index(system, "eta")] = 0.43;
  PeriodicOrbit orbit = shoot(system, p, settle(system, p, Vector::Zero(2), {.periods = 300}).state, 1);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.to = 0.405;
  options.switch_generations = 0;
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  const auto points = points_of(branches[0], PointType::BP);
  REQUIRE(points.size() == 1);
  CHECK(points[0].status == PointStatus::converged);
  CHECK(std::abs(points[0].orbit.multipliers.values[0] - 1.0) < 1e-9);
  CHECK(points_of(branches[0], PointType::LP).empty());
  CHECK(check_branch(system, branches[0]).empty());
  // Symmetric: half a period later the state has the opposite sign.
  p = points[0].orbit.parameters;
  const Trajectory half = simulate(system, p, 0.0, points[0].orbit.state, {.t_end = forcing_period(system, p) / 2.0});
  CHECK((half.x + points[0].orbit.state).norm() < 1e-9);
  // Independent check: the multiplier of orbits found by shooting on both sides, interpolated to +1.
  double excess[2];
  const double distance = 1e-4;
  for (const int side : {0, 1}) {
    p[index(system, "eta")] = points[0].value + (side == 0 ? -distance : distance);
    const PeriodicOrbit beside = shoot(system, p, points[0].orbit.state, 1);
    REQUIRE(beside.converged());
    excess[side] = beside.multipliers.values[0].real() - 1.0;
  }
  REQUIRE(excess[0] * excess[1] < 0.0);
  // The error of linear interpolation over 2e-4 is of second order.
  CHECK(std::abs(distance * (excess[0] + excess[1]) / (excess[0] - excess[1])) < 1e-6);
}

TEST_CASE("a double multiplier -1 has no normal form, and the doubled branch tells its criticality (fixed)") {
  // Without damping the multiplier -1 is double: its coefficient was the rounding of a division by zero, 6e12.
  SystemWriter writer;
  writer.forcing("eta").parameter("eta", "2.3");
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {}, {{"1"}}, {"0.5*cos(eta*t) - x^2"}});
  const HybridSystem system = equations::make_system(writer.system).system;
  const PeriodicOrbit orbit = shoot(system, parameters(system), vector({-0.12, 0.0}), 1);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.parameter = "eta";
  options.to = 2.0;
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  REQUIRE(branches.size() == 2);
  const auto doublings = points_of(branches[0], PointType::PD);
  REQUIRE(doublings.size() == 1);
  CHECK(doublings[0].value == Approx(2.1203876071).epsilon(1e-9));
  CHECK(doublings[0].details.count("normal_form") == 0);
  CHECK(text_detail(doublings[0], "criticality_from") == "branch");
  CHECK(text_detail(doublings[0], "criticality") == "supercritical");
}

TEST_CASE("a branch that ends at a value which the model refuses is listed with its points (fixed)") {
  // The values tried beyond the limit stayed in the equations, and no branch was listed at all.
  SystemWriter writer;
  writer.forcing("eta").parameter("eta", "0.8");
  ParameterInfo limited;
  limited.name = "K";
  limited.default_value = 3e5;
  limited.lower = 0.0;
  limited.upper = 1e6;
  writer.parameter(limited);
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.1"}}, {{"1"}}, {"0.9*eta^2*cos(eta*t) - K*1e-6*x^3"}});
  writer.stop("stop", "0.6 - x", "newton", {"0.8"});
  const HybridSystem system = equations::make_system(writer.system).system;
  const Attractor attractor = approach_attractor(system, parameters(system), vector({0.0, 0.0}), {});
  REQUIRE(attractor.orbit);
  ContinuationOptions options;
  options.parameter = "K";
  options.to = 0.0;
  options.switch_generations = 0;
  const std::vector<Branch> branches = continue_orbit(system, *attractor.orbit->whole, options);
  REQUIRE_FALSE(branches.empty());
  CHECK(branches[0].points.size() > 5);
  CHECK(branches[0].points.back().value < 3e4);
}
