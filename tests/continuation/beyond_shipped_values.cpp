// SPDX-License-Identifier: GPL-3.0-or-later
// Branches beyond the shipped parameter values, where they once ended for a wrong reason or had false special points. The
// reference values are from 40-digit arithmetic on the closed forms (one impact) and on the equations of the events (several).
#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

using Settings = std::vector<std::pair<const char*, double>>;

struct Run {
  const char* oscillator = "linear";
  const char* contact = "newton";
  Settings set = {};
  std::string parameter = "eta";
  double from = 0.0, to = 0.0;
  Vector start = {};  ///< empty: the orbit on which the motion from rest settles
  int period = 1;
  int generations = 1;
};

/// The computation of `graze continue`.
std::vector<Branch> follow(const Run& run) {
  const HybridSystem system = make_oscillator(run.oscillator, run.contact);
  Vector p = parameters(system, run.set);
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, run.parameter))] = run.from;
  Vector start = run.start;
  if (start.size() == 0) start = settle(system, p, Vector{{0.0, 0.0}}).state;
  const PeriodicOrbit orbit = shoot(system, p, start, run.period);
  REQUIRE(orbit.converged());
  ContinuationOptions options;
  options.parameter = run.parameter;
  options.to = run.to;
  options.switch_generations = run.generations;
  return continue_orbit(system, orbit, options);
}

const SpecialPoint* nearest(const std::vector<Branch>& branches, PointType type, double value) {
  const SpecialPoint* found = nullptr;
  for (const Branch& branch : branches)
    for (const SpecialPoint& point : branch.special_points)
      if (point.type == type && (!found || std::abs(point.value - value) < std::abs(found->value - value))) found = &point;
  return found;
}

/// Requires a special point of that type there, to the digits of `value`.
const SpecialPoint& point_at(const std::vector<Branch>& branches, PointType type, double value, double digits = 1e-12) {
  const SpecialPoint* found = nearest(branches, type, value);
  INFO(point_type_name(type) << " at " << fmt::format("{:.15g}", value));
  REQUIRE(found);
  CHECK(std::abs(found->value - value) < digits);
  CHECK(found->status == PointStatus::converged);
  return *found;
}

void check_points(const Run& run, const std::vector<Branch>& branches) {
  const double low = std::min(run.from, run.to), high = std::max(run.from, run.to);
  for (const Branch& branch : branches) {
    INFO("branch " << branch.id << ": " << branch.message);
    CHECK(branch.stop != BranchStop::step_too_small);
    for (const BranchPoint& point : branch.points) CHECK((point.value >= low - 1e-12 && point.value <= high + 1e-12));
    if (branch.stop == BranchStop::grazing) {
      const SpecialPoint& end = branch.special_points.back();
      const auto impacts = std::get<std::vector<double>>(end.details.at("impacts"));
      CHECK(impacts[0] == branch.points.back().impacts);
      CHECK(text_detail(end, "kind") == (impacts[1] < impacts[0] ? "lost" : "gained"));
    }
    const auto parent = std::find_if(branches.begin(), branches.end(),
                                     [&](const Branch& other) { return branch.parent && other.id == branch.parent->branch; });
    if (parent == branches.end() || branch.period != 2 * parent->period) continue;
    for (const SpecialPoint& special : parent->special_points)
      if (special.label == branch.parent->label && special.type == PointType::PD)
        CHECK(branch.points.front().impacts == 2 * special.orbit.impacts);
  }
}

}  // namespace

TEST_CASE("no branch is closed in the middle of its range where an impact passes phase 0 (fixed)") {
  struct Case {
    Run run;
    BranchStop stop;
    double at;
  };
  const std::vector<Case> cases{
      {{.set = {{"r", 1.0}}, .from = 1.3, .to = 0.4}, BranchStop::grazing, 0.713493954739418},
      {{.set = {{"r", 0.3}, {"k_r", 0.8}}, .from = 1.3, .to = 0.4}, BranchStop::grazing, 0.853170448497},
      {{.set = {{"k_r", 0.537}, {"r", 0.803}, {"b", 0.037}}, .from = 0.8, .to = 1.331}, BranchStop::reached_bound, 1.331},
      {{.set = {{"b", 0.1111}, {"r", 1.274}, {"k_r", 0.617}},
        .from = 0.47861193499758936,
        .to = 0.6,
        .start = Vector{{1.2628090510167732, 0.064340247123506148}},
        .period = 2},
       BranchStop::grazing,
       0.484706123187655}};
  for (const Case& c : cases) {
    const std::vector<Branch> branches = follow(c.run);
    REQUIRE_FALSE(branches.empty());
    INFO(branches.front().message);
    CHECK(branches.front().stop == c.stop);
    CHECK(std::abs(branches.front().stop_value - c.at) < 1e-12);
  }
}

TEST_CASE("with zero restitution a branch changes between an impact and sticking in both directions (fixed)") {
  // A mass released at rest where cos(eta t) = r returns to r exactly T later: at eta = 1.2646035797545 for r = 0.7, at
  // 1.4684442530694 for r = 0.4. There is no other change at this point.
  struct Case {
    double r, at, from, to;
  };
  for (const Case& c : {Case{0.7, 1.2646035797545, 1.2, 1.5},
                        {0.7, 1.2646035797545, 1.4, 1.2},
                        {0.4, 1.4684442530694, 1.4, 1.6},
                        {0.4, 1.4684442530694, 1.55, 1.4}}) {
    INFO("r = " << c.r << " from " << c.from);
    const HybridSystem system = make_oscillator("linear", "newton");
    const Vector p = parameters(system, {{"b", 0.04}, {"r", c.r}, {"k_r", 0.0}, {"eta", c.from}});
    Vector start = settle(system, p, Vector{{0.0, 0.0}}).state;
    PeriodicOrbit orbit = shoot(system, p, start, 1);
    if (!orbit.converged() || orbit.impacts == 0) orbit = shoot(system, p, Vector{{-0.86, 2.08}}, 1);
    REQUIRE(orbit.converged());
    REQUIRE(orbit.impacts == 1);
    ContinuationOptions options;
    options.to = c.to;
    options.switch_generations = 0;
    const Branch branch = continue_orbit(system, orbit, options).front();
    CHECK(branch.stop == BranchStop::reached_bound);
    // On both sides of the change, motions nearby settle on the orbit of the branch.
    for (const BranchPoint& point : branch.points) {
      if (!point.stable || std::abs(point.value - c.at) > 0.05) continue;
      Vector there = p;
      there[static_cast<Eigen::Index>(parameter_index(system.parameters, "eta"))] = point.value;
      const Vector state = settle(system, there, point.state(), {.periods = 50}).state;
      CHECK((state - point.state()).norm() < 1e-9);
      // Within 1e-6 of the change the contact force is below the threshold that distinguishes sticking from impact.
      if (std::abs(point.value - c.at) > 1e-6) CHECK((point.isolated_impacts == point.impacts) == (point.value > c.at));
    }
  }
}

TEST_CASE("a sticking branch is not reported as closed (fixed)") {
  const std::vector<Branch> branches =
      follow({.set = {{"b", 0.02}, {"r", 0.5}, {"k_r", 0.8}}, .from = 0.05, .to = 0.5, .generations = 0});
  REQUIRE_FALSE(branches.empty());
  for (const Branch& branch : branches) CHECK(branch.message.find("closed") == std::string::npos);
  // It sticks up to there. Beyond, the last complete series loses an impact.
  CHECK(branches.front().points.back().value > 0.2);
}

TEST_CASE("no branch point is reported where an impact passes phase 0 and no period doubling is missed there (fixed)") {
  const Run run{.set = {{"b", 0.0193}, {"r", 0.101}, {"k_r", 0.92}}, .from = 2.0, .to = 0.4};
  const std::vector<Branch> branches = follow(run);
  CHECK(types_of(branches.front()) == "PD PD GR");
  point_at(branches, PointType::PD, 1.005767505143);
  for (const Branch& branch : branches) CHECK(points_of(branch, PointType::BP).empty());
}

TEST_CASE("the grazing at the end of a branch belongs to it and is lost or gained in its direction (fixed)") {
  const Run first{.set = {{"b", 0.2238}, {"r", 0.657}, {"k_r", 0.419}}, .from = 1.1, .to = 0.35};
  const std::vector<Branch> branches = follow(first);
  // Near complete chatter, beyond twenty impacts, grazings are so close that the last branch may end for that reason.
  for (const Branch& branch : branches)
    if (branch.points.back().impacts < 19) check_points(first, {branch});
  CHECK(text_detail(point_at(branches, PointType::GR, 0.5307327245, 1e-10), "kind") == "lost");
  const Run second{.set = {{"b", 0.0084}, {"r", 0.904}, {"k_r", 0.536}},
                   .from = 0.45107263705067274,
                   .to = 4.0,
                   .start = Vector{{0.83387983691392569, -0.12863355396764863}}};
  const std::vector<Branch> others = follow(second);
  check_points(second, others);
  const SpecialPoint& lost = point_at(others, PointType::GR, 0.4869874366, 1e-9);
  CHECK(std::get<std::vector<double>>(lost.details.at("impacts")) == std::vector<double>{7.0, 6.0});
}

TEST_CASE("a doubled branch has twice the impacts of its parent and its side gives the criticality (fixed)") {
  const Run cantilever{.oscillator = "cantilever",
                       .contact = "linear",
                       .set = {{"b", 0.026}, {"beta", 36.0 / 35.0}, {"xi", 0.08}, {"r", 0.079}, {"k_S", 25.0}},
                       .from = 1.05,
                       .to = 0.4,
                       .generations = 2};
  const std::vector<Branch> beam = follow(cantilever);
  check_points(cantilever, beam);
  CHECK(text_detail(point_at(beam, PointType::PD, 0.512198586842), "criticality") == "supercritical");
  point_at(beam, PointType::GR, 0.59071750105, 1e-11);
  const std::vector<Branch> rigid = follow({.set = {{"b", 0.2238}, {"r", 0.657}, {"k_r", 0.419}}, .from = 1.1, .to = 0.35});
  CHECK(text_detail(point_at(rigid, PointType::PD, 0.532814055737), "criticality") == "subcritical");
}

TEST_CASE("a branch that begins on the end of its range closer to a fold than one step stays in the range (fixed)") {
  const Run run{.set = {}, .from = 0.5711974034103127, .to = 0.4, .start = Vector{{0.46831931136246866, -1.2735306561703334}}};
  const std::vector<Branch> branches = follow(run);
  check_points(run, branches);
  CHECK(types_of(branches.front()) == "LP");
  CHECK(branches.front().stop == BranchStop::reached_bound);
}

TEST_CASE("no fold is reported at the start of a doubled branch and no branch point in a conservative resonance (fixed)") {
  const std::vector<Branch> doubled = follow({.set = {{"b", 0.0105}, {"r", 2.457}, {"k_r", 0.722}},
                                              .from = 0.87222473004942148,
                                              .to = 4.0,
                                              .start = Vector{{2.4563045468793786, -0.71222033200435921}}});
  const SpecialPoint& pd = point_at(doubled, PointType::PD, 0.987191085443);
  for (const Branch& branch : doubled)
    for (const SpecialPoint& fold : points_of(branch, PointType::LP)) CHECK(std::abs(fold.value - pd.value) > 1e-7);
  const std::vector<Branch> flat = follow({.set = {{"b", 0.0087}, {"xi", 1.0}, {"r", 2.14}, {"k_r", 0.863}},
                                           .from = 0.942,
                                           .to = 1.13,
                                           .start = Vector{{2.114228362733895, 1.4338921970671534}}});
  const SpecialPoint& birth = point_at(flat, PointType::PD, 0.9954905537891808);
  for (const Branch& branch : flat)
    for (const SpecialPoint& fold : points_of(branch, PointType::LP)) CHECK(std::abs(fold.value - birth.value) > 1e-8);
  // The computation completes without an exception: all orbits at eta = 1 have multipliers 1.
  const std::vector<Branch> conservative = follow({.set = {{"b", 0.0}}, .from = 1.3, .to = 0.7});
  CHECK(conservative.size() > 1);
  for (const Branch& branch : conservative)
    for (const SpecialPoint& point : points_of(branch, PointType::BP)) CHECK(std::abs(point.value - 1.0) > 1e-6);
}

TEST_CASE("folds up to their grazing are found in the coordinates of the events and errors are bounds (fixed)") {
  const std::vector<Branch> branches = follow({.set = {{"b", 0.2952}, {"r", 0.159}, {"k_r", 0.315}}, .from = 1.7, .to = 0.35});
  // 2.4e-7 away from its grazing, where the weak impact is slower than at any point of the branch.
  const SpecialPoint& fold = point_at(branches, PointType::LP, 0.961013163576, 1e-11);
  CHECK(fold.precision < 1e-10);
  CHECK(text_detail(*nearest(branches, PointType::GR, 0.961012927713), "scenario") == "nonsmooth-fold");
  const std::vector<Branch> many = follow({.set = {{"b", 0.0105}, {"k_r", 0.722}, {"eta", 2.37}},
                                           .parameter = "r",
                                           .from = -0.34070546370726627,
                                           .to = -1.0,
                                           .start = Vector{{-2.1694950450973563, 0.66076558500330633}}});
  int folds = 0;
  for (const Branch& branch : many) folds += branch.points.back().impacts >= 5 ? 1 : 0;
  CHECK(folds > 4);
}

TEST_CASE("the criticality near a grazing uses the coordinates of the events (fixed)") {
  const HybridSystem system = make_oscillator("linear", "newton");
  struct At {
    double eta, near;
  };
  for (const At& at : {At{0.80002, 0.36139}, At{0.80005, 0.36134}, At{0.8001, 0.36127}}) {
    const Vector p = parameters(system, {{"b", 0.02}, {"r", 1.0}, {"k_r", 0.9}, {"eta", at.eta}, {"xi", at.near}});
    const SearchResult found = search_orbits(system, p, 2);
    ContinuationOptions options;
    options.parameter = "xi";
    LocateResult located;
    for (const PeriodicOrbit& orbit : found.orbits)
      if (!located.point && orbit.admissible == Admissibility::admissible && orbit.impacts == 1)
        located = locate(system, orbit, PointType::PD, at.near, 1e-3, options);
    REQUIRE(located.point);
    INFO("eta = " << at.eta << ", xi = " << fmt::format("{:.12g}", located.point->value));
    CHECK(text_detail(*located.point, "criticality") == "supercritical");
    if (located.point->details.contains("normal_form"))
      CHECK(std::abs(number_detail(*located.point, "normal_form")) > 10.0 * number_detail(*located.point, "normal_form_error"));
  }
}

TEST_CASE("a grazing from inside a soft contact is located as accurately as one from outside (fixed)") {
  // Two contacts merge: the flight between them grazes.
  const Settings soft{{"b", 0.05}, {"r", 0.0}, {"k_S", 15.0}};
  std::vector<double> found[2];
  for (const bool down : {true, false}) {
    const Run run{.contact = "linear", .set = soft, .from = down ? 4.0 : 0.3, .to = down ? 0.3 : 4.0, .generations = 0};
    for (const SpecialPoint& point : points_of(follow(run).front(), PointType::GR)) {
      CHECK(point.status == PointStatus::converged);
      CHECK(point.precision < 1e-12);
      found[down ? 0 : 1].push_back(point.value);
    }
  }
  CHECK(found[0].size() > 8);
  REQUIRE(found[0].size() == found[1].size());
  for (auto& list : found) std::sort(list.begin(), list.end());
  for (std::size_t k = 0; k < found[0].size(); ++k) CHECK(std::abs(found[0][k] - found[1][k]) < 1e-12);
}

TEST_CASE("states of a grazing orbit after its touch are not displaced by rounding (fixed)") {
  const Settings set = {{"b", 0.03}, {"r", 0.0}, {"k_r", 0.9}};
  const double value = 3.013028054882214;
  const Vector start{{-0.0033614965028724323, 0.24230179542866798}};
  const std::vector<Branch> branches =
      follow({.set = set, .from = 3.0216995199236902, .to = 3.0, .start = start, .period = 4, .generations = 0});
  const SpecialPoint& touching = point_at(branches, PointType::GR, value);
  // It touches in its second period: the other periods are free runs from state to state.
  const HybridSystem system = make_oscillator("linear", "newton");
  Vector p = parameters(system, set);
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, "eta"))] = touching.value;
  const std::vector<Vector>& states = touching.orbit.states;
  REQUIRE(states.size() == 4);
  Propagator propagator(system, p);
  for (const std::size_t k : {0, 2, 3}) {
    Transition transition;
    carry(propagator, 0.0, forcing_period(system, p), states[k], {.sensitivity = Sensitivity::none}, transition);
    CHECK((transition.x1 - states[(k + 1) % 4]).norm() < 1e-10);
  }
}
