// SPDX-License-Identifier: GPL-3.0-or-later
// Neimark-Sacker points, which need four states, and branch points, which need a symmetry.
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include "support/branches.hpp"
#include "support/driven_self_excited.hpp"
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
