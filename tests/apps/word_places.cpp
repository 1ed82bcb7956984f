// SPDX-License-Identifier: GPL-3.0-or-later
// Words in a crowded picture: they avoid each other, lines and marks, or are left out.
#include <graze/apps/drawing/word_places.hpp>

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze::apps;

TEST_CASE("words stand beside a single mark") {
  WordPlaces places(20.0);
  places.add_mark({40.0, 10.0});
  const auto placed = places.beside_mark({{40.0, 10.0}}, "PD1", 10.0);
  REQUIRE(placed);
  CHECK(placed->leader.empty());
  CHECK(placed->anchor.column == 40.0);
  CHECK(placed->anchor.row == 10.0);
}

TEST_CASE("words of one mark do not cover each other") {
  WordPlaces places(20.0);
  std::vector<Cell> anchors;
  for (int i = 0; i < 12; ++i) {
    const auto placed = places.beside_mark({{40.0, 10.0}}, "PD1", 20.0);
    REQUIRE(placed);
    for (const Cell& other : anchors)
      CHECK((std::abs(other.column - placed->anchor.column) > 3.6 || std::abs(other.row - placed->anchor.row) > 1.0));
    if (i > 0) {  // a line leads to the mark
      REQUIRE(placed->leader.size() == 3);
      CHECK(placed->leader.front().column == 40.0);
      CHECK(placed->leader.front().row == 10.0);
    }
    anchors.push_back(placed->anchor);
  }
}

TEST_CASE("words stay inside the axes and off lines") {
  WordPlaces places(20.0);
  const auto corner = places.beside_mark({{92.0, 20.0}}, "GR1", 10.0);
  REQUIRE(corner);
  CHECK(corner->anchor.column < 92.0 - 5.0);
  CHECK(corner->anchor.row < 19.0);
  // Lines everywhere: there is no room within reach or along the curve, but far above them there is.
  for (double row = 0.0; row < 12.0; row += 0.5) places.add_line({0.0, row}, {92.0, row});
  CHECK_FALSE(places.beside_mark({{40.0, 4.0}}, "LP1", 6.0));
  CHECK_FALSE(places.along_curve({{40.0, 4.0}, {41.0, 4.0}}, "1/2"));
  const auto above = places.along_curve({{40.0, 4.0}, {41.0, 11.5}}, "1/2");
  REQUIRE(above);
  CHECK(above->anchor.row >= 11.5);
}
