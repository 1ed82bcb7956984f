// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits symmetric between two barriers touch both together: one grazing, not two, at which several contacts are lost or
// gained.
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"
#include "support/two_sided_orbit.hpp"
#include "support/two_sided_oscillator.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

constexpr double b = 0.05, k_r = 0.8;

/// Forcing amplitude at which the impactless orbit reaches r = 1.
double grazing_at(double eta) { return std::hypot(1.0 - eta * eta, 2.0 * b * eta); }

ContinuationOptions options_around(double grazing) {
  ContinuationOptions options;
  options.parameter = "xi";
  options.from = 0.9 * grazing;
  options.to = 1.2 * grazing;
  options.switch_generations = 0;
  return options;
}

std::vector<double> impacts_at(const SpecialPoint& grazing) {
  return std::get<std::vector<double>>(grazing.details.at("impacts"));
}

}  // namespace

TEST_CASE("a symmetric branch loses its impacts at both rigid barriers in one grazing and continues without them") {
  const HybridSystem system = two_sided_oscillator(true);
  // The orbits with both impacts end on the impactless grazing, from below (nonsmooth fold) or from above (persistence).
  struct Row {
    double eta, start;
  };
  for (const Row& row : std::vector<Row>{{0.65, 1.03}, {0.9, 1.03}, {1.3, 0.97}}) {
    const double grazing = grazing_at(row.eta), xi = row.start * grazing;
    std::optional<TwoSidedOrbit> exact;
    for (const int branch : {1, -1})
      if (const auto found = two_sided_orbit(b, xi, row.eta, 1, k_r, branch); found && (!exact || found->v < exact->v))
        exact = found;
    REQUIRE(exact);
    INFO("eta " << row.eta << ", speed " << static_cast<double>(exact->v));
    const Vector p = parameters(system, {{"b", b}, {"xi", xi}, {"eta", row.eta}, {"r", 1.0}, {"k_r", k_r}});
    const PeriodicOrbit orbit = shoot(system, p, Vector{{static_cast<double>(exact->x), static_cast<double>(exact->x_dot)}}, 1);
    REQUIRE(orbit.impacts == 2);
    const BranchGraph graph = follow_branches(system, {{orbit, {row.start > 1.0 ? -1 : 1}}}, options_around(grazing));
    REQUIRE(graph.branches.size() >= 2);
    CHECK(graph.cut_off.empty());
    const Branch& branch = graph.branches[0];
    REQUIRE(branch.stop == BranchStop::grazing);
    const auto grazings = points_of(branch, PointType::GR);
    REQUIRE(grazings.size() == 1);
    CHECK(std::abs(grazings[0].value - grazing) < 1e-12);
    CHECK(text_detail(grazings[0], "kind") == "lost");
    CHECK(impacts_at(grazings[0]) == std::vector<double>{2.0, 0.0});
    REQUIRE(grazings[0].orbit.events.size() == 2);  // both touch, one at each barrier
    for (const EventRecord& touch : grazings[0].orbit.events) {
      CHECK(touch.normal_speed == 0.0);
      CHECK(std::abs(std::abs(touch.x_minus[0]) - 1.0) < 1e-9);
    }
    CHECK(grazings[0].orbit.events[0].event != grazings[0].orbit.events[1].event);
    CHECK(text_detail(grazings[0], "scenario") == (row.start > 1.0 ? "persistence" : "nonsmooth-fold"));
    CHECK(text_detail(grazings[0], "scenario_from") == "directions; several contacts touch together");
    // Beyond: the impactless orbit, down to the end of the range.
    CHECK(graph.branches[1].parent->label == grazings[0].label);
    CHECK(graph.branches[1].points.front().impacts == 0);
    CHECK(graph.branches[1].stop == BranchStop::reached_bound);
    CHECK(graph.branches[1].points.back().value == Approx(0.9 * grazing).epsilon(1e-14));
    // The points agree with the closed form.
    for (const BranchPoint& point : branch.points) {
      double distance = INFINITY;
      for (const int root : {1, -1})
        if (const auto at = two_sided_orbit(b, point.value, row.eta, 1, k_r, root))
          distance = std::min(distance, std::hypot(static_cast<double>(at->x) - point.state()[0],
                                                   static_cast<double>(at->x_dot) - point.state()[1]));
      CHECK(distance < 1e-9);
    }
  }
}

TEST_CASE("a symmetric branch passes the grazing of both elastic stops as one point in both directions") {
  const HybridSystem system = two_sided_oscillator(false);
  for (const double eta : {0.65, 0.9, 1.3}) {
    const double grazing = grazing_at(eta), xi = 0.97 * grazing;
    const Vector p = parameters(system, {{"b", b}, {"xi", xi}, {"eta", eta}, {"r", 1.0}});
    const PeriodicOrbit orbit = shoot(system, p, xi / (grazing * grazing) * Vector{{1.0 - eta * eta, 2.0 * b * eta * eta}}, 1);
    REQUIRE(orbit.impacts == 0);
    const std::vector<Branch> up = follow_branches(system, {{orbit, {1}}}, options_around(grazing)).branches;
    INFO("eta " << eta);
    REQUIRE(up.size() == 1);
    CHECK(up[0].stop == BranchStop::reached_bound);
    CHECK(up[0].points.size() < 50);  // the steps do not become tiny
    const auto gained = points_of(up[0], PointType::GR);
    REQUIRE(gained.size() == 1);
    CHECK(gained[0].status == PointStatus::converged);
    CHECK(std::abs(gained[0].value - grazing) < 1e-13);
    CHECK(impacts_at(gained[0]) == std::vector<double>{0.0, 2.0});
    CHECK(check_branch(system, up[0]) == std::vector<std::string>{});
    // Back from an orbit with both contacts. (At eta = 0.65 the orbits lose their symmetry 3e-4 beyond the grazing: a step
    // back may pass over to the symmetry-broken branch there.)
    const BranchPoint& end = up[0].points.at(gained[0].after_point + 2);
    REQUIRE(end.impacts == 2);
    if (eta == 0.65) continue;
    Vector there = p;
    there[static_cast<Eigen::Index>(parameter_index(system.parameters, "xi"))] = end.value;
    const PeriodicOrbit with_contacts = shoot(system, there, end.state(), 1);
    REQUIRE(with_contacts.converged());
    const std::vector<Branch> back =
        follow_branches(system, {{with_contacts, {end.value > grazing ? -1 : 1}}}, options_around(grazing)).branches;
    const auto lost = points_of(back[0], PointType::GR);
    REQUIRE(lost.size() == 1);
    CHECK(lost[0].status == PointStatus::converged);
    CHECK(std::abs(lost[0].value - grazing) < 1e-13);
    CHECK(impacts_at(lost[0]) == std::vector<double>{2.0, 0.0});
  }
}
