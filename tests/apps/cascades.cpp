// SPDX-License-Identifier: GPL-3.0-or-later
// Cascades of period doublings: their points, and the ratios of their intervals.
#include "graze_program.hpp"

#include <graze/apps/results/cascades.hpp>

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

SpecialPoint doubling(const std::string& label, double value, std::size_t after, int period) {
  SpecialPoint point;
  point.type = PointType::PD;
  point.label = label;
  point.value = value;
  point.after_point = after;
  point.orbit.period = period;
  point.orbit.states.assign(static_cast<std::size_t>(period), Vector::Constant(2, value));
  return point;
}

Branch branch(int id, int period, std::vector<SpecialPoint> points, std::optional<BranchParent> parent = {}) {
  Branch branch;
  branch.id = id;
  branch.period = period;
  branch.parent = std::move(parent);
  branch.special_points = std::move(points);
  branch.stop = BranchStop::reached_bound;
  return branch;
}

/// Ends the branch where it meets the orbit of half its period, with states 0.1 to both sides of that orbit.
void return_to(Branch& branch, double value) {
  BranchPoint last;
  last.value = value + 1e-5;
  for (int i = 0; i < branch.period; ++i)
    last.states.emplace_back(Vector::Constant(2, value + (i < branch.period / 2 ? 0.1 : -0.1)));
  branch.points.push_back(last);
  branch.stop = BranchStop::returned;
}

std::string labels(const Cascade& cascade) {
  std::string text;
  for (const Doubling& point : cascade.points) text += point.label + " ";
  return text;
}

}  // namespace

TEST_CASE("the ratios of a cascade are those of its intervals") {
  // Intervals 0.4, 0.1, 0.02: ratios 4 and 5.
  const std::vector<Branch> branches = {branch(1, 1, {doubling("PD1", 0.9, 3, 1)}),
                                        branch(2, 2, {doubling("PD2", 0.5, 3, 2)}, BranchParent{1, "PD1"}),
                                        branch(3, 4, {doubling("PD3", 0.4, 3, 4)}, BranchParent{2, "PD2"}),
                                        branch(4, 8, {doubling("PD4", 0.38, 3, 8)}, BranchParent{3, "PD3"})};
  const std::vector<Cascade> found = cascades(branches);
  REQUIRE(found.size() == 1);
  CHECK(labels(found[0]) == "PD1 PD2 PD3 PD4 ");
  REQUIRE(found[0].ratios().size() == 2);
  CHECK(found[0].ratios()[0] == Approx(4.0).epsilon(1e-12));
  CHECK(found[0].ratios()[1] == Approx(5.0).epsilon(1e-12));
  CHECK_THAT(cascades_text(found, "eta"), Contains("4.6692") && Contains("4 -> 8") && Contains("-0.02"));
  const Json json = json_of(found);
  REQUIRE(json.size() == 1);
  CHECK(json[0]["points"].size() == 4);
  CHECK(json[0]["points"][1] == Json({{"label", "PD2"}, {"branch", 2}, {"period", 2}, {"value", 0.5}}));
  CHECK(json[0]["ratios"].size() == 2);
}

TEST_CASE("two doublings are no cascade") {
  const std::vector<Branch> branches = {branch(1, 1, {doubling("PD1", 0.9, 3, 1)}),
                                        branch(2, 2, {doubling("PD2", 0.5, 3, 2)}, BranchParent{1, "PD1"}),
                                        branch(3, 4, {}, BranchParent{2, "PD2"})};
  CHECK(cascades(branches).empty());
  CHECK(cascades_text({}, "eta").empty());
  CHECK(json_of(std::vector<Cascade>()) == Json::array());
}

TEST_CASE("a doubled branch that ends at another doubling belongs to two cascades") {
  // A bubble: PD3, PD5 upwards from PD1; PD4, PD6 downwards from PD2, at which the doubled branch ends.
  std::vector<Branch> branches = {
      branch(1, 1, {doubling("PD1", 0.1, 1, 1), doubling("PD2", 0.9, 8, 1)}),
      branch(2, 2, {doubling("PD3", 0.2, 1, 2), doubling("PD4", 0.8, 8, 2)}, BranchParent{1, "PD1"}),
      branch(3, 4, {doubling("PD5", 0.22, 1, 4), doubling("PD6", 0.78, 8, 4)}, BranchParent{2, "PD3"})};
  return_to(branches[1], 0.9);
  return_to(branches[2], 0.8);
  const std::vector<Cascade> found = cascades(branches);
  REQUIRE(found.size() == 2);
  CHECK(labels(found[0]) == "PD1 PD3 PD5 ");
  CHECK(labels(found[1]) == "PD2 PD4 PD6 ");
  CHECK(found[0].ratios()[0] == Approx(5.0).epsilon(1e-12));
  CHECK(found[1].ratios()[0] == Approx(5.0).epsilon(1e-12));
}

TEST_CASE("continue compares the cascade of the damped Hertz oscillator with Feigenbaum's constant") {
  const Outcome outcome = call(
      {"continue", problem("hertz-damped"), "--from", "0.746", "--to", "0.7335", "--period", "2", "--switch", "2", "--quiet"});
  INFO(outcome.err);
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("cascade of period doublings") && Contains("0.743324589428") && Contains("0.737223314409") &&
                              Contains("0.735533477351") && Contains("Feigenbaum's constant 4.6692"));
  // (0.737223314409 - 0.743324589428) / (0.735533477351 - 0.737223314409)
  CHECK_THAT(outcome.out, Contains("3.6106"));
}
