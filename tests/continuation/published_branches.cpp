// SPDX-License-Identifier: GPL-3.0-or-later
// Branches of the six published systems, and their points against data/reference.toml and the figures in the issue.
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <map>

using namespace graze;

namespace {

using Values = std::map<std::string, double>;

struct Run {
  HybridSystem system;
  std::vector<Branch> branches;
};

Vector parameters(const HybridSystem& system, const Values& values) {
  Vector p = default_parameters(system.parameters);
  for (const auto& [name, value] : values) p[static_cast<Eigen::Index>(parameter_index(system.parameters, name))] = value;
  return p;
}

Run run(const char* oscillator, const char* law, const Values& values, int period, const ContinuationOptions& options) {
  Run result{make_oscillator(oscillator, law), {}};
  const Vector p = parameters(result.system, values);
  const PeriodicOrbit orbit = shoot(result.system, p, settle(result.system, p, Vector::Zero(2)).state, period);
  REQUIRE(orbit.converged());
  result.branches = continue_orbit(result.system, orbit, options);
  for (const Branch& branch : result.branches)
    for (const std::string& violation : check_branch(result.system, branch)) FAIL_CHECK(violation);
  return result;
}

const SpecialPoint& only(const Branch& branch, PointType type) {
  const SpecialPoint* found = nullptr;
  for (const SpecialPoint& point : branch.special_points) {
    if (point.type != type) continue;
    REQUIRE(found == nullptr);
    found = &point;
  }
  REQUIRE(found != nullptr);
  return *found;
}

}  // namespace

TEST_CASE("damped Hertz: the 1/1 branch from 0.95 to 0.70, its period doubling and that of the doubled branch") {
  ContinuationOptions options;
  options.to = 0.70;
  const Run r = run("linear", "hertz", {{"b_H", 0.1}, {"eta", 0.95}}, 1, options);
  const SpecialPoint& first = r.branches[0].special_points[1];
  REQUIRE(first.type == PointType::PD);
  // data/reference.toml, quadruple precision.
  CHECK(std::abs(first.value - 0.919542643087348) < 1e-12);
  CHECK(first.status == PointStatus::converged);
  CHECK(first.interval[0] <= first.value);
  CHECK(first.value <= first.interval[1]);
  CHECK(std::abs(first.orbit.multipliers.values[0] + 1.0) < 1e-10);
  CHECK(std::abs(first.orbit.multipliers.values[1] + 0.40214437228) < 1e-10);
  CHECK(std::abs(first.orbit.state[0] - 2.0518811079659517) < 1e-12);
  CHECK(std::abs(first.orbit.state[1] - 1.3954715728845985) < 1e-11);  // x' changes 12 times faster with eta than x
  CHECK(std::get<std::string>(first.details.at("criticality")) == "supercritical");
  const Branch& doubled = r.branches[1];
  CHECK(doubled.parent->label == first.label);
  CHECK(doubled.points.back().value == Approx(0.70).epsilon(1e-14));
  const SpecialPoint& second = only(doubled, PointType::PD);
  CHECK(std::abs(second.value - 0.74332458942847206392) < 1e-12);  // data/reference.toml
}

TEST_CASE("damped Hertz: locate gives the period doubling from either side and with the general integrator") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  for (const double eta : {0.93, 0.915}) {
    const Vector p = parameters(system, {{"b_H", 0.1}, {"eta", eta}});
    const PeriodicOrbit orbit = shoot(system, p, Vector{{2.05, 1.4}}, 1);
    REQUIRE(orbit.converged());
    for (const FlowKind kind : {FlowKind::automatic, FlowKind::general}) {
      ContinuationOptions options;
      options.shooting.flow.kind = kind;
      const LocateResult result = locate(system, orbit, PointType::PD, 0.92, 0.01, options);
      REQUIRE(result.point);
      // The general integrator passes entry and exit without regularisation: a few more rounding errors.
      CHECK(std::abs(result.point->value - 0.919542643087348) < (kind == FlowKind::general ? 1e-11 : 1e-12));
    }
    const LocateResult none = locate(system, orbit, PointType::NS, 0.92, 0.01, {});
    CHECK_FALSE(none.point);
    CHECK(none.message.find("no NS lies on the branch") != std::string::npos);
    CHECK(none.message.find("found instead: PD at 0.919542643") != std::string::npos);
  }
}

TEST_CASE("damped Hertz: labels of the cascade appear in order") {
  ContinuationOptions options;
  options.to = 0.73;
  options.switch_generations = 4;
  const Run r = run("linear", "hertz", {{"b_H", 0.1}, {"eta", 0.95}}, 1, options);
  // Along the stable part of each generation, from the doubled branch on.
  std::vector<std::string> labels;
  for (const Branch& branch : r.branches) {
    if (!branch.parent) continue;
    for (const BranchPoint& point : branch.points) {
      const std::string z = label(point.impacts, branch.period);
      if (point.stable && (labels.empty() || labels.back() != z)) labels.push_back(z);
    }
  }
  CHECK(labels == std::vector<std::string>{"2/2", "1/2", "2/2", "4/4", "8/8", "7/8", "14/16"});
}

TEST_CASE(
    "undamped Hertz, Newton, linear stop and the beams give their branches by the same call beyond the published values too") {
  const auto follow = [](const char* oscillator, const char* law, const Values& values, int period, double to) {
    ContinuationOptions options;
    options.to = to;
    return run(oscillator, law, values, period, options);
  };
  const Run undamped = follow("linear", "hertz", {{"eta", 0.95}}, 1, 0.90);
  CHECK(std::abs(only(undamped.branches[0], PointType::PD).value - 0.92936567429431479526) < 1e-12);  // data/reference.toml
  const Run newton = follow("linear", "newton", {{"eta", 1.0}}, 1, 0.97);
  CHECK(std::abs(only(newton.branches[0], PointType::PD).value - 0.98631687344838721201) < 1e-12);  // data/reference.toml
  const Values beam = {{"b", 0.026}, {"r", 0.079}, {"xi", 0.08}, {"eta", 0.6}};
  for (const char* law : {"hertz", "linear"}) {
    const Run r = follow("cantilever", law, beam, 1, 0.595);
    CHECK(r.branches[0].stop == BranchStop::reached_bound);
  }
  const Values other = {{"b", 0.08}, {"r", 1.2}, {"xi", 1.3}, {"eta", 0.8}};
  for (const char* law : {"hertz", "linear", "newton"}) {
    Values values = other;
    if (std::string(law) == "newton") values["k_r"] = 0.7;
    const Run r = follow("linear", law, values, 1, 0.85);
    INFO(law);
    CHECK(r.branches[0].points.size() > 3);
  }
}

TEST_CASE("any parameter can be continued in both directions") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b_H", 0.1}, {"eta", 0.95}});
  const PeriodicOrbit orbit = shoot(system, p, Vector{{2.0, 1.5}}, 1);
  for (const ParameterInfo& parameter : system.parameters) {
    if (parameter.name == "beta") continue;  // beta = 0 has a separate flow; see below
    const double here = p[static_cast<Eigen::Index>(parameter_index(system.parameters, parameter.name))];
    ContinuationOptions options;
    options.parameter = parameter.name;
    options.to = 1.02 * here;
    options.from = 0.98 * here;
    options.both_directions = true;
    const std::vector<Branch> branches = continue_orbit(system, orbit, options);
    INFO(parameter.name);
    REQUIRE(branches.size() >= 2);
    CHECK(branches[0].points.back().value == Approx(1.02 * here).epsilon(1e-13));
    CHECK(branches[1].points.back().value == Approx(0.98 * here).epsilon(1e-13));
    CHECK(branches[0].direction == 1);
    CHECK(branches[1].direction == -1);
    for (const Branch& branch : branches) CHECK(check_branch(system, branch).empty());
  }
  ContinuationOptions cubic;
  cubic.parameter = "beta";
  cubic.to = 0.01;
  CHECK(continue_orbit(system, orbit, cubic)[0].stop == BranchStop::reached_bound);
}

TEST_CASE("misuse of continuation is refused in one sentence and interruption keeps the points") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 1.0}});
  const PeriodicOrbit orbit = shoot(system, p, settle(system, p, Vector::Zero(2)).state, 1);
  ContinuationOptions options;
  options.parameter = "etta";
  CHECK_THROWS_WITH(continue_orbit(system, orbit, options), Catch::Contains("did you mean \"eta\"?"));
  options.parameter = "k_r";
  options.to = 1.2;
  CHECK_THROWS_WITH(continue_orbit(system, orbit, options), Catch::Contains("the range of k_r goes to 1.2; allowed is [0, 1]"));
  options.parameter = "eta";
  options.to = 1.0;
  CHECK_THROWS_WITH(continue_orbit(system, orbit, options), Catch::Contains("the range of eta is empty"));
  options.to = 0.9;
  int made = 0;
  options.progress = [&](const Branch&) { ++made; };
  options.cancelled = [&] { return made >= 5; };
  const std::vector<Branch> branches = continue_orbit(system, orbit, options);
  CHECK(branches[0].stop == BranchStop::interrupted);
  CHECK(branches[0].points.size() == 6);
}

TEST_CASE("a branch reaches the end of the range of the model and its last point lies exactly on it") {
  const HybridSystem system = make_oscillator("linear", "newton");
  for (const double to : {1.0, 0.0}) {
    const Vector p = parameters(system, {{"k_r", 0.6}, {"eta", 0.95}});
    const PeriodicOrbit orbit = shoot(system, p, Vector{{1.5, 1.5}}, 1);
    REQUIRE(orbit.converged());
    ContinuationOptions options;
    options.parameter = "k_r";
    options.to = to;
    options.switch_generations = 0;
    const std::vector<Branch> branches = continue_orbit(system, orbit, options);
    CHECK(branches[0].stop == BranchStop::reached_bound);
    CHECK(branches[0].points.back().value == to);
    CHECK(check_branch(system, branches[0]).empty());
  }
}

TEST_CASE("check_branch detects changed values") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"b_H", 0.1}, {"eta", 0.95}});
  ContinuationOptions options;
  options.to = 0.91;
  options.switch_generations = 0;
  const Branch good = continue_orbit(system, shoot(system, p, Vector{{2.0, 1.5}}, 1), options)[0];
  REQUIRE(check_branch(system, good).empty());
  Branch moved = good, flipped = good, outside = good, back = good;
  moved.points[3].nodes[0][0] += 1e-6;
  CHECK_FALSE(check_branch(system, moved).empty());
  flipped.points[2].stable = !flipped.points[2].stable;
  CHECK_FALSE(check_branch(system, flipped).empty());
  outside.special_points[1].value += 1e-3;
  CHECK_FALSE(check_branch(system, outside).empty());
  back.points[4].arclength = 0.0;
  CHECK_FALSE(check_branch(system, back).empty());
  // Reversed in the middle, and retraced along itself.
  Branch again = good;
  const std::size_t half = good.points.size() / 2;
  for (std::size_t k = half; k < good.points.size(); ++k) {
    again.points[k] = good.points[2 * half - k];
    again.points[k].arclength = good.points[k].arclength;
  }
  const std::vector<std::string> violations = check_branch(system, again);
  const auto says = [&](const char* words) {
    return std::any_of(violations.begin(), violations.end(), [&](const std::string& v) { return v.find(words) != v.npos; });
  };
  CHECK(says("it may have jumped to another branch"));
  CHECK(says("an orbit that the branch has met before"));
}
