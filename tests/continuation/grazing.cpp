// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/one_impact_orbit.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

struct Case {
  HybridSystem system;
  Vector p;
  double& operator[](const char* name) { return p[static_cast<Eigen::Index>(parameter_index(system.parameters, name))]; }
};

Case oscillator(const char* law) {
  Case c{make_oscillator("linear", law), {}};
  c.p = default_parameters(c.system.parameters);
  return c;
}

PeriodicOrbit settled(const Case& c, int period) {
  return shoot(c.system, c.p, settle(c.system, c.p, Vector::Zero(2)).state, period);
}

/// eta at which the impactless amplitude equals r, for b = 0.05, r = 2, xi = 1 (DESIGN section 2).
const double impactless_grazing = std::sqrt((1.99 - std::sqrt(1.99 * 1.99 - 3.0)) / 2.0);

/// Labels z = p/n along a branch, without repetitions.
std::vector<std::string> labels(const Branch& branch) {
  std::vector<std::string> list;
  for (const BranchPoint& point : branch.points) {
    const std::string z = label(point.impacts, branch.period);
    if (list.empty() || list.back() != z) list.push_back(z);
  }
  return list;
}

}  // namespace

TEST_CASE("the impactless orbit grazes where its amplitude equals the clearance for every law") {
  for (const char* law : {"hertz", "linear", "newton"}) {
    Case c = oscillator(law);
    c["eta"] = 0.70;
    const PeriodicOrbit orbit = settled(c, 1);
    REQUIRE(orbit.impacts == 0);
    ContinuationOptions options;
    options.to = 0.7120;
    options.switch_generations = 0;
    const std::vector<Branch> branches = continue_orbit(c.system, orbit, options);
    const auto grazings = points_of(branches.front(), PointType::GR);
    INFO(law);
    REQUIRE(grazings.size() == 1);
    // Closed form; the rounding of the orbit moves the point by a few 1e-15.
    CHECK(std::abs(grazings[0].value - impactless_grazing) < 1e-13);
    CHECK(grazings[0].status == PointStatus::converged);
    CHECK(text_detail(grazings[0], "kind") == "gained");
    CHECK(text_detail(grazings[0], "scenario") == (std::string(law) == "newton" ? "persistence" : "smooth"));
    CHECK(std::get<std::vector<double>>(grazings[0].details.at("impacts")) == std::vector<double>{0.0, 1.0});
    if (std::string(law) == "newton") {
      REQUIRE(branches.size() == 2);
      CHECK(branches[1].parent->label == grazings[0].label);
      CHECK(branches[1].points.back().impacts == 1);
      CHECK(branches[1].stop == BranchStop::reached_bound);
    } else {
      CHECK(branches.front().stop == BranchStop::reached_bound);
    }
    for (const Branch& branch : branches) CHECK(check_branch(c.system, branch).empty());
  }
}

TEST_CASE("the error bar of a grazing covers the step errors of the general integrator") {
  Case c = oscillator("newton");
  c["eta"] = 0.70;
  for (const double tolerance : {1e-13, 1e-11, 1e-9, 1e-8}) {
    INFO("tolerance " << tolerance);
    ContinuationOptions options;
    options.shooting.flow = {.kind = FlowKind::general, .tolerance = tolerance};
    options.to = 0.7120;
    options.switch_generations = 0;
    const PeriodicOrbit orbit = shoot(c.system, c.p, steady_response(c.p), 1, options.shooting);
    REQUIRE(orbit.converged());
    const std::vector<Branch> branches = continue_orbit(c.system, orbit, options);
    const auto grazings = points_of(branches.front(), PointType::GR);
    REQUIRE(grazings.size() == 1);
    const double off = std::abs(grazings[0].value - impactless_grazing);
    CHECK(off < grazings[0].precision);
    CHECK(grazings[0].precision < 3.0 * off + 1e-13);
  }
}

TEST_CASE("the impactless orbit grazes also where its maximum lies next to phase 0") {
  Case c = oscillator("newton");
  for (const auto& [name, value] : {std::pair("b", 0.010422852115207468), {"k_r", 0.9399025589058793}, {"r", 1.3113797800059455}})
    c[name] = value;
  c["eta"] = 0.48;
  const PeriodicOrbit orbit = shoot(c.system, c.p, steady_response(c.p), 1);
  REQUIRE(orbit.converged());
  REQUIRE(orbit.impacts == 0);
  ContinuationOptions options;
  options.parameter = "eta";
  options.to = 0.5;
  const std::vector<Branch> branches = continue_orbit(c.system, orbit, options);
  CHECK(branches[0].stop == BranchStop::grazing);
  const auto grazings = points_of(branches[0], PointType::GR);
  REQUIRE(grazings.size() == 1);
  CHECK(std::abs(grazings[0].value - 0.4873521031679208) < 1e-12);  // ((1 - eta^2)^2 + 4 b^2 eta^2) r^2 = 1
}

TEST_CASE("a soft contact passes through grazing: labels change at GR points and the branch continues") {
  Case c = oscillator("hertz");
  c["b_H"] = 0.1;
  ContinuationOptions options;
  options.to = 0.70;
  const std::vector<Branch> branches = continue_orbit(c.system, settled(c, 1), options);
  REQUIRE(branches.size() >= 2);
  CHECK(labels(branches[0]) == std::vector<std::string>{"1/1", "0/1"});
  CHECK(labels(branches[1]) == std::vector<std::string>{"2/2", "1/2", "2/2"});
  for (const Branch& branch : branches) {
    CHECK(branch.stop == BranchStop::reached_bound);
    CHECK(check_branch(c.system, branch).empty());
    // One grazing for each change of the label, and all have converged.
    CHECK(points_of(branch, PointType::GR).size() + 1 == labels(branch).size());
    for (const SpecialPoint& point : points_of(branch, PointType::GR)) {
      CHECK(point.status == PointStatus::converged);
      CHECK(point.precision < 1e-12);
      CHECK(text_detail(point, "scenario") == "smooth");
    }
  }
  CHECK(points_of(branches[0], PointType::GR)[0].value == Approx(impactless_grazing).epsilon(1e-14));
  CHECK(points_of(branches[1], PointType::GR)[0].value == Approx(0.910530).margin(2e-6));  // known to six digits
}

TEST_CASE("a located grazing is a tangency of the free motion for the general integrator too") {
  Case c = oscillator("hertz");
  c["b_H"] = 0.1;
  c["eta"] = 0.912;
  const PeriodicOrbit orbit = settled(c, 2);
  REQUIRE(orbit.impacts == 2);
  double values[2];
  for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
    ContinuationOptions options;
    options.shooting.flow.kind = kind;
    const LocateResult found = locate(c.system, orbit, PointType::GR, 0.9105, 0.002, options);
    REQUIRE(found.point);
    CHECK(text_detail(*found.point, "kind") == "lost");
    values[kind == FlowKind::general] = found.point->value;
    if (kind == FlowKind::general) continue;
    const double t = std::get<double>(found.point->details.at("time"));
    const Trajectory run = simulate(c.system, found.point->orbit.parameters, 0.0, found.point->orbit.state, {.t_end = t});
    CHECK(std::abs(run.x[0] - 2.0) < 1e-12);  // on the barrier ...
    CHECK(std::abs(run.x[1]) < 1e-12);        // ... at zero speed
  }
  CHECK(std::abs(values[0] - values[1]) <
        1e-11);  // the error of the general integrator over two periods, amplified by d(eta)/d(gap)
}

TEST_CASE("restitution 0.8 in xi: fold and grazing 3e-5 apart agree with the closed form and the impactless orbit continues") {
  Case c = oscillator("newton");
  c["k_r"] = 0.8;
  c["r"] = 1.0;
  c["eta"] = 1.0;
  const support::OneImpactFamily exact = support::one_impact_family({.b = 0.05, .eta = 1.0, .r = 1.0, .k_r = 0.8}, 1);
  ContinuationOptions options;
  options.parameter = "xi";
  options.to = 0.05;
  const std::vector<Branch> branches = continue_orbit(c.system, settled(c, 1), options);
  REQUIRE(branches.size() == 2);
  const auto folds = points_of(branches[0], PointType::LP), grazings = points_of(branches[0], PointType::GR);
  REQUIRE(folds.size() == 1);
  REQUIRE(grazings.size() == 1);
  CHECK(folds[0].status == PointStatus::converged);
  CHECK(std::abs(folds[0].value - exact.xi_fold()) < 1e-12);
  CHECK(std::abs(grazings[0].value - exact.xi_grazing()) < 1e-13);
  CHECK(std::abs(grazings[0].value - 0.1) < 1e-13);  // where the impactless amplitude xi / (2 b) equals r
  CHECK(grazings[0].value - folds[0].value > 2e-5);
  CHECK(text_detail(grazings[0], "scenario") == "nonsmooth-fold");
  CHECK(branches[0].stop == BranchStop::grazing);
  CHECK(labels(branches[1]) == std::vector<std::string>{"0/1"});
  CHECK(branches[1].points.front().value < 0.1);
  for (const Branch& branch : branches) CHECK(check_branch(c.system, branch).empty());
  // Along the branch xi is the function of the impact speed in the closed form.
  for (const BranchPoint& point : branches[0].points) {
    c["xi"] = point.value;
    const Trajectory run = simulate(c.system, c.p, 0.0, point.state(), {.t_end = forcing_period(c.system, c.p)});
    REQUIRE(run.events.size() == 1);
    CHECK(std::abs(exact.xi(run.events[0].normal_speed) - point.value) < 1e-11);
  }
}

TEST_CASE("the scenario of a lost impact follows the sign of sin(w n T) for both signs and several restitutions") {
  int seen[2] = {0, 0};
  for (const double k_r : {0.3, 0.8, 1.0}) {
    for (const double eta : {0.71, 0.9, 1.15, 1.3}) {
      for (const double r : {0.5, 1.0}) {
        Case c = oscillator("newton");
        c["k_r"] = k_r;
        c["r"] = r;
        c["eta"] = eta;
        const support::OneImpactFamily exact = support::one_impact_family({.b = 0.05, .eta = eta, .r = r, .k_r = k_r}, 1);
        // The impactless orbit starts below its grazing amplitude and gains an impact there.
        c["xi"] = 0.9 * exact.xi_grazing();
        const double detuning = 1.0 - eta * eta, drag = 2.0 * 0.05 * eta, D = detuning * detuning + drag * drag;
        const Vector forced = c["xi"] / D * Vector{{detuning, drag * eta}};
        const PeriodicOrbit orbit = shoot(c.system, c.p, forced, 1);
        REQUIRE(orbit.impacts == 0);
        ContinuationOptions options;
        options.parameter = "xi";
        options.to = 1.05 * exact.xi_grazing();
        const std::vector<Branch> branches = continue_orbit(c.system, orbit, options);
        const auto grazings = points_of(branches[0], PointType::GR);
        INFO("k_r " << k_r << " eta " << eta << " r " << r);
        REQUIRE(grazings.size() == 1);
        CHECK(std::abs(grazings[0].value - exact.xi_grazing()) < 1e-13);
        const bool persistence = std::sin(exact.turn) > 0.0;
        CHECK(text_detail(grazings[0], "scenario") == (persistence ? "persistence" : "nonsmooth-fold"));
        ++seen[persistence];
      }
    }
  }
  CHECK(seen[0] >= 3);
  CHECK(seen[1] >= 3);
}

TEST_CASE("the Newton oscillator: the unstable doubled branch of the subcritical period doubling ends on a grazing") {
  Case c = oscillator("newton");
  c["eta"] = 1.0;
  ContinuationOptions options;
  options.to = 0.95;
  const std::vector<Branch> branches = continue_orbit(c.system, settled(c, 1), options);
  REQUIRE(branches.size() == 3);
  const auto doublings = points_of(branches[0], PointType::PD);
  REQUIRE(doublings.size() == 1);
  CHECK(std::abs(doublings[0].value - 0.98631687344838721201) < 1e-12);  // data/reference.toml
  CHECK(text_detail(doublings[0], "criticality") == "subcritical");
  CHECK(branches[1].stop == BranchStop::grazing);
  CHECK_FALSE(branches[1].points.front().stable);
  CHECK(branches[1].stop_value == Approx(0.98718).margin(1e-5));  // known to five digits
  CHECK(labels(branches[2]) == std::vector<std::string>{"1/2"});
  CHECK(branches[2].stop == BranchStop::reached_bound);
  for (const Branch& branch : branches) CHECK(check_branch(c.system, branch).empty());
}
