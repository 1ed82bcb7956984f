// SPDX-License-Identifier: GPL-3.0-or-later
// Special points that several branches share are listed once.
#include "graze_program.hpp"

#include <graze/apps/results/same_points.hpp>

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;

namespace {

Branch branch_with(int id, PointType type, double value, std::vector<Vector> states) {
  SpecialPoint point;
  point.type = type;
  point.label = "P" + std::to_string(id);
  point.value = value;
  point.precision = 1e-14;
  point.orbit.states = std::move(states);
  Branch branch;
  branch.id = id;
  branch.special_points = {point};
  return branch;
}

}  // namespace

TEST_CASE("special points are the same if value and orbit are up to a shift and a multiple of the period") {
  const Vector a{{0.25, -1.5}}, b{{1.0, 0.5}}, near{{0.25, -1.4999}};
  const std::vector<Branch> branches = {
      branch_with(1, PointType::GR, 0.7, {a, b}),        branch_with(2, PointType::GR, 0.7 + 1e-14, {b, a}),
      branch_with(3, PointType::GR, 0.7, {b, a, b, a}),  branch_with(4, PointType::GR, 0.7, {near, b}),
      branch_with(5, PointType::GR, 0.7 + 1e-9, {a, b}), branch_with(6, PointType::LP, 0.7, {a, b}),
      branch_with(7, PointType::EP, 0.7, {a, b}),        branch_with(8, PointType::EP, 0.7, {a, b})};
  const SamePoints same = same_points(branches);
  CHECK(same.size() == 2);
  for (const std::size_t k : {1, 2}) {
    REQUIRE(same.contains(&branches[k].special_points.front()));
    CHECK(same.at(&branches[k].special_points.front()).branch == &branches.front());
  }
}

TEST_CASE("a grazing of several branches is listed once and the JSON names the branches") {
  // eta = 0.686489977652: 3/3 ends there, 2/3 begins and ends there.
  const TemporaryFolder folder;
  const Outcome outcome =
      call("diagram", "newton-elastic",
           {"--skeleton", "--from", "0.684", "--to", "0.74", "--max-period", "3", "--json", folder.file("d.json")});
  REQUIRE(outcome.code == 0);
  const Json json = Json::parse(read_file(folder.file("d.json")));
  std::size_t referring = 0;
  for (const Json& branch : json["branches"])
    for (const Json& point : branch["special_points"]) {
      if (!point.contains("same_as")) continue;
      ++referring;
      for (const Json& other : json["branches"])
        for (const Json& first : other["special_points"])
          if (first["label"] == point["same_as"]["label"]) {
            CHECK(other["id"] == point["same_as"]["branch"]);
            CHECK(std::abs(first["value"].get<double>() - point["value"].get<double>()) < 1e-12);
          }
    }
  CHECK(referring >= 1);
  const std::string value = "0.686489977652";
  const std::size_t first = outcome.out.find(value);
  REQUIRE(first != std::string::npos);
  CHECK(outcome.out.find(value, first + 1) == std::string::npos);
}
