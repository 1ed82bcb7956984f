// SPDX-License-Identifier: GPL-3.0-or-later
// Speculative rows of a map: the start of each point, cancelled points, and committed points.
#include <graze/floquet/follow/map_row.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <memory>
#include <vector>

using namespace graze;

namespace {

Vector at(double x) { return Vector{{x, 0.0}}; }

MapPoint found(MapType type, double x = 0.0) {
  MapPoint point;
  point.type = type;
  point.state = at(x);
  return point;
}

/// Publishes the state of the next point, so that the point after it may begin.
std::shared_ptr<MapRow::Point> published(MapRow& row, double x) {
  auto point = row.begin_next();
  row.publish(*point, at(x));
  return point;
}

/// A row of four points: two published, the third begun.
struct ThreeBegun {
  std::vector<MapPoint> out = std::vector<MapPoint>(4);
  MapRow row{out};
  std::shared_ptr<MapRow::Point> first = published(row, 0.5), second = published(row, 0.6), third = row.begin_next();
};

using Next = MapRow::Next;

}  // namespace

TEST_CASE("map row: each point begins from the orbit of the one before") {
  std::vector<MapPoint> out(3);
  const bool backwards = GENERATE(false, true);
  MapRow row(out, backwards);
  for (std::size_t k = 0; k < 3; ++k) {
    REQUIRE(row.next() == Next::likely);
    const auto point = row.begin_next();
    CHECK(row.next() == Next::none);
    CHECK(row.place(*point) == (backwards ? 2 - k : k));
    REQUIRE(point->from.has_value() == (k > 0));
    if (k > 0) CHECK((*point->from)[0] == static_cast<double>(k - 1));
    CHECK_FALSE(row.finished());
    CHECK(row.finish(*point, found(MapType::periodic, static_cast<double>(k))) == 1);
  }
  CHECK(row.finished());
  CHECK(row.next() == Next::none);
  CHECK(out.front().state[0] == (backwards ? 2.0 : 0.0));
}

TEST_CASE("map row: after a published point the next begins at once and stays if the point is chaotic") {
  std::vector<MapPoint> out(3);
  MapRow row(out);
  const auto first = published(row, 0.5);
  REQUIRE(row.next() == Next::likely);
  const auto second = row.begin_next();
  CHECK((*second->from)[0] == 0.5);
  CHECK(row.finish(*second, found(MapType::periodic, 2.0)) == 0);  // the first might cancel it
  const auto third = row.begin_next();
  CHECK((*third->from)[0] == 2.0);
  const MapType type = GENERATE(MapType::chaotic, MapType::undecided);
  CHECK(row.finish(*first, found(type, 1.0)) == 2);
  CHECK_FALSE(second->dropped);
  CHECK(row.finish(*third, found(MapType::periodic)) == 1);
  CHECK(row.finished());
  CHECK(out[0].type == type);
  CHECK(out[1].state[0] == 2.0);
}

TEST_CASE_METHOD(ThreeBegun, "map row: an orbit or a lost motion cancels the points begun from the published state") {
  CHECK(row.finish(*third, found(MapType::chaotic)) == 0);
  const MapType type = GENERATE(MapType::periodic, MapType::lost);
  CHECK(row.finish(*first, found(type, 7.0)) == 1);
  CHECK(second->dropped);
  CHECK(third->dropped);
  CHECK(out[2].type == MapType::not_run);
  row.publish(*second, at(9.0));  // too late
  CHECK(row.finish(*second, found(MapType::periodic, 9.0)) == 0);
  CHECK(out[1].type == MapType::not_run);
  const auto anew = row.begin_next();
  CHECK(anew->number == 1);
  REQUIRE(anew->from.has_value() == (type == MapType::periodic));
  if (anew->from) CHECK((*anew->from)[0] == 7.0);
}

TEST_CASE("map row: the more points are uncommitted the less likely is the next to be kept") {
  std::vector<MapPoint> out(20);
  MapRow row(out);
  std::vector<std::shared_ptr<MapRow::Point>> points;
  while (row.next() == Next::likely) points.push_back(published(row, 0.0));
  CHECK(points.size() > 1);
  CHECK(points.size() < 20);
  CHECK(row.next() == Next::unlikely);
  row.finish(*points[0], found(MapType::chaotic));
  CHECK(row.next() == Next::likely);
}

TEST_CASE_METHOD(ThreeBegun, "map row: a failed point ends the row") {
  row.finish(*third, found(MapType::periodic));
  CHECK(row.finish(*second, found(MapType::not_run)) == 0);
  CHECK(third->dropped);
  CHECK(row.next() == Next::none);
  CHECK_FALSE(row.finished());
  CHECK(row.finish(*first, found(MapType::chaotic)) == 1);
  CHECK(row.finished());
  CHECK(std::all_of(out.begin() + 1, out.end(), [](const MapPoint& point) { return point.type == MapType::not_run; }));
}
