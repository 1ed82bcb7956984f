// SPDX-License-Identifier: GPL-3.0-or-later
// Branches do not depend on the unit in which their parameter is given, and reach the limits of its range.
#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include "support/branches.hpp"
#include "support/system_texts.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

ParameterInfo not_negative(const char* name, double value) {
  ParameterInfo info;
  info.name = name;
  info.default_value = value;
  info.lower = 0.0;
  return info;
}

/// x'' + 2 b x' + x = cos(eta t), x <= 2, elastic impacts at eta = 0.99, with the damping b = B / unit.
HybridSystem damped_in(double unit) {
  SystemWriter writer;
  writer.system.name = "damped";
  writer.states({"x", "v"}).forcing("eta").parameter("eta", "0.99");
  writer.parameter(not_negative("B", 0.05 * unit));
  writer.definition("b", fmt::format("B/{}", unit));
  writer.mode("free", "x' = v\nv' = cos(eta*t) - 2*b*v - x").event({"stop", "impact", "x - 2", "v = -v", "", ""});
  return equations::make_system(writer.system).system;
}

/// A Duffing oscillator between two stops at -r and r, with r = R / unit.
HybridSystem between_stops_in(double unit) {
  SystemWriter writer;
  writer.system.name = "duffing";
  writer.states({"x", "v"}).forcing("eta").parameter("eta", "0.8");
  writer.parameter(not_negative("R", 0.6 * unit));
  writer.definition("r", fmt::format("R/{}", unit));
  writer.mode("free", "x' = v\nv' = 0.6*cos(eta*t) - 0.1*v - x - x^3/2");
  writer.event({"upper", "impact", "x - r", "v = -0.8*v", "", ""}).event({"lower", "impact", "-x - r", "v = -0.8*v", "", ""});
  return equations::make_system(writer.system).system;
}

/// An oscillator before a spring with the damping cs = P / unit, from 0.3 on.
HybridSystem soft_stop_in(double unit) {
  SystemWriter writer;
  writer.system.name = "soft";
  writer.forcing("w").parameter("w", "1.3");
  writer.parameter(not_negative("P", 0.3 * unit));
  writer.definition("cs", fmt::format("P/{}", unit));
  writer.mechanics({"x"}, {"v"}, {{{"1"}}, {{"0.12"}}, {{"1"}}, {"0.6*cos(w*t)"}})
      .stop("wall", "0.5 - x", "linear", {"50", "cs"});
  return equations::make_system(writer.system).system;
}

std::vector<Branch> followed_in(const HybridSystem& system, const char* parameter, double to, ContinuationOptions options = {}) {
  const Vector p = default_parameters(system.parameters);
  const PeriodicOrbit start = shoot(system, p, settle(system, p, Vector::Zero(2)).state, 1);
  REQUIRE(start.converged());
  options.parameter = parameter;
  options.to = to;
  return continue_orbit(system, start, options);
}

/// Compares branches in a parameter of this unit with those in a parameter of unit 1.
void check_same_in_unit(const std::vector<Branch>& branches, const std::vector<Branch>& reference, double unit) {
  INFO("unit " << unit);
  REQUIRE(branches.size() == reference.size());
  for (std::size_t k = 0; k < branches.size(); ++k) {
    const Branch &one = branches[k], &other = reference[k];
    INFO("branch " << k << ": " << one.message);
    CHECK(one.stop == other.stop);
    CHECK(one.direction == other.direction);
    CHECK(one.stop_value / unit == Approx(other.stop_value).epsilon(1e-9).margin(1e-12));
    REQUIRE(types_of(one) == types_of(other));
    for (std::size_t s = 0; s < one.special_points.size(); ++s) {
      const SpecialPoint &point = one.special_points[s], &same = other.special_points[s];
      CHECK(point.status == same.status);
      // The first point of a branch born at a grazing is chosen, near it.
      const bool chosen = point.type == PointType::EP && s == 0;
      CHECK(point.value / unit == Approx(same.value).epsilon(chosen ? 1e-5 : 1e-9).margin(1e-12));
      CHECK(point.precision / unit <= 20.0 * same.precision + 1e-13);
      CHECK(point.precision / unit >= 0.05 * same.precision - 1e-13);
    }
  }
}

constexpr std::array other_units{1e-3, 1e-6, 1e-10, 1e5, 1e10};

}  // namespace

TEST_CASE("folds, grazings and the branches born there do not depend on the unit of the parameter") {
  const std::vector<Branch> reference = followed_in(damped_in(1.0), "B", 0.3);
  REQUIRE(reference.size() == 2);
  CHECK(types_of(reference[0]) == "LP GR");
  CHECK(reference[1].stop == BranchStop::reached_bound);
  for (const double unit : other_units) check_same_in_unit(followed_in(damped_in(unit), "B", 0.3 * unit), reference, unit);
}

TEST_CASE("branch points and the branches that cross there do not depend on the unit of the parameter") {
  const std::vector<Branch> reference = followed_in(between_stops_in(1.0), "R", 1.5);
  REQUIRE(reference.size() == 4);
  CHECK(types_of(reference[0]) == "BP GR");
  for (const double unit : other_units) check_same_in_unit(followed_in(between_stops_in(unit), "R", 1.5 * unit), reference, unit);
}

TEST_CASE("zeros of a scalar do not depend on the unit of the parameter") {
  ContinuationOptions options;
  options.further_tests = {zero_test("speed", [](const BranchPoint& point) { return point.state()[0] - 1.1; })};
  options.switch_generations = 0;
  const std::vector<Branch> reference = followed_in(damped_in(1.0), "B", 0.2, options);
  REQUIRE(points_of(reference[0], PointType::UZ).size() == 1);
  for (const double unit : other_units)
    check_same_in_unit(followed_in(damped_in(unit), "B", 0.2 * unit, options), reference, unit);
}

TEST_CASE("a branch reaches the limit of its parameter in any unit, without points that crowd there") {
  for (const double unit : {1.0, 1e-6, 1e6, 1e10}) {
    INFO("unit " << unit);
    const std::vector<Branch> branches = followed_in(soft_stop_in(unit), "P", 0.0);
    REQUIRE(branches.size() == 1);
    INFO(branches[0].message);
    CHECK(branches[0].stop == BranchStop::reached_bound);
    CHECK(branches[0].stop_value == 0.0);
    CHECK(points_of(branches[0], PointType::MX).empty());
    const auto near = [&](const BranchPoint& point) { return point.value < 1e-3 * unit; };
    CHECK(std::count_if(branches[0].points.begin(), branches[0].points.end(), near) <= 2);
  }
}

TEST_CASE("a branch that ends before a limit of its parameter says why") {
  // Without its spring the mass has no isolated orbit: any place is one.
  SystemWriter writer;
  writer.system.name = "spring";
  writer.states({"x", "v"}).forcing("w").parameter("w", "0.8").parameter(not_negative("k", 1.0));
  writer.mode("free", "x' = v\nv' = cos(w*t) - 0.1*v - k*x");
  const std::vector<Branch> branches = followed_in(equations::make_system(writer.system).system, "k", 0.0);
  REQUIRE(branches.size() == 1);
  CHECK(branches[0].stop == BranchStop::step_too_small);
  CHECK(branches[0].message.find("(no isolated orbit is found at the end of the range)") != std::string::npos);
}
