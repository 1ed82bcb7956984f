// SPDX-License-Identifier: GPL-3.0-or-later
// Branches of autonomous orbits: limit cycles of van der Pol's oscillator before a stop, against cycles found anew by simulation.
#include <graze/continuation/graph/continuation.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/van_der_pol_stop.hpp"

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

TEST_CASE("autonomous orbits are continued, with their durations") {
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
    // From rest the motion comes to the cycle by itself.
    const Vector p = parameters(system, {{name, to}});
    const Trajectory settled = simulate(system, p, 0.0, vector({0.5, 0.0}), {.t_end = 2000.0});
    const Trajectory to_impact = simulate(system, p, 0.0, settled.x, {.t_end = 50.0, .max_events = 1});
    const Trajectory round = simulate(system, p, 0.0, to_impact.x, {.t_end = 50.0, .max_events = 1});
    CHECK(end.duration == Approx(round.t).epsilon(1e-9));
    CHECK(std::abs(end.multipliers.values.front()) < 1.0);
  }
}
