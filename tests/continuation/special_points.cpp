// SPDX-License-Identifier: GPL-3.0-or-later
// Properties of the orbit at a special point: its stability, and its number of contacts.
#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/attractor/settle.hpp>
#include <graze/lib/models/oscillator.hpp>

#include "support/branches.hpp"
#include "support/checks.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace graze;
using namespace graze::support;

namespace {

PeriodicOrbit settled(const HybridSystem& system, const Vector& p) {
  return shoot(system, p, settle(system, p, Vector::Zero(2)).state, 1);
}

std::vector<EventRecord> contacts_begun(const PeriodicOrbit& orbit) {
  std::vector<EventRecord> list;
  std::copy_if(orbit.events.begin(), orbit.events.end(), std::back_inserter(list),
               [](const EventRecord& event) { return begins_contact(event.kind); });
  return list;
}

}  // namespace

TEST_CASE("at a period doubling and at a fold an orbit is reported neither as stable nor as unstable") {
  const HybridSystem hertz = make_oscillator("linear", "hertz"), beam = make_oscillator("cantilever", "newton");
  const Vector p = parameters(hertz, {{"b_H", 0.1}, {"eta", 0.95}});
  const Vector q = parameters(beam, {{"b", 0.05}, {"xi", 20.0}, {"r", 10.0}, {"eta", 1.1}});
  ContinuationOptions options;
  options.to = 0.65;
  options.switch_generations = 0;
  options.user_values = {0.94, 0.9};
  std::vector<SpecialPoint> points = continue_orbit(hertz, settled(hertz, p), options).front().special_points;
  const std::vector<SpecialPoint> more = continue_orbit(beam, settled(beam, q), options).front().special_points;
  points.insert(points.end(), more.begin(), more.end());
  int doublings = 0, folds = 0, compared = 0;
  for (const SpecialPoint& point : points) {
    INFO(point_type_name(point.type) << " at " << point.value);
    doublings += point.type == PointType::PD ? 1 : 0;
    folds += point.type == PointType::LP ? 1 : 0;
    if (point.type == PointType::PD || point.type == PointType::LP || point.type == PointType::BP) {
      CHECK(is_marginal(point.type));
      CHECK_FALSE(stable_at(point).has_value());
    } else {
      // The grazing of a soft contact is among them: the return map is smooth there.
      CHECK_FALSE(is_marginal(point.type));
      REQUIRE(stable_at(point).has_value());
      CHECK(*stable_at(point) == (std::abs(point.orbit.multipliers.values.front()) <= 1.0));
      ++compared;
    }
  }
  CHECK(doublings >= 1);
  CHECK(folds >= 1);
  CHECK(compared >= 8);  // both ends and two values of each branch
}

TEST_CASE("a grazing orbit has its stated number of contacts including the one that touches") {
  for (const char* law : {"hertz", "linear", "newton"}) {
    const HybridSystem system = make_oscillator("linear", law);
    const Vector p = parameters(system, {{"eta", 0.70}});
    const PeriodicOrbit orbit = shoot(system, p, steady_response(p), 1);
    INFO(law);
    REQUIRE(orbit.impacts == 0);
    // Located with the parameter decreasing, the impact is lost, and the orbit still has it.
    const LocateResult located = locate(system, orbit, PointType::GR, 0.7107, 0.002, {});
    REQUIRE(located.point);
    const SpecialPoint& point = *located.point;
    CHECK(text_detail(point, "kind") == "lost");
    CHECK(point.orbit.impacts == 1);
    const std::vector<EventRecord> contacts = contacts_begun(point.orbit);
    REQUIRE(contacts.size() == 1);
    CHECK(contacts[0].normal_speed == 0.0);
    CHECK(std::abs(contacts[0].x_minus[0] - 2.0) < 1e-12);  // at the barrier
    CHECK(std::abs(contacts[0].x_minus[1]) < 1e-12);
    CHECK(contacts[0].t == number_detail(point, "time"));
    // Every contact ends.
    CHECK(point.orbit.events.size() == (std::string(law) == "newton" ? 1 : 2));
    // A hard contact that grazes: the return map has no derivative.
    CHECK(stable_at(point).has_value() == (std::string(law) != "newton"));
    // Along the branch, with the parameter increasing, the impact is gained: the orbit does not have it yet.
    ContinuationOptions options;
    options.to = 0.7120;
    options.switch_generations = 0;
    const std::vector<Branch> branches = continue_orbit(system, orbit, options);
    const std::vector<SpecialPoint> gained = points_of(branches.front(), PointType::GR);
    REQUIRE(gained.size() == 1);
    CHECK(gained[0].orbit.impacts == 0);
    CHECK(gained[0].orbit.events.empty());
  }
}
