// SPDX-License-Identifier: GPL-3.0-or-later
// Crowded pictures: omitted elements, and the positions of the words.
#include <graze/apps/drawing/label_places.hpp>
#include <graze/apps/drawing/legend.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/results/skeleton_report.hpp>

#include <catch2/catch.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace graze;
using namespace graze::apps;
using Catch::Matchers::Contains;

namespace {

/// `count` branches, of periods 1, 2, 3, 1, 2, ..., each with a period doubling.
Json branches_of(int count) {
  Json result = {
      {"schema", "graze.branch/1"},   {"command", "continue"}, {"model", {{"oscillator", "linear"}, {"contact", "newton"}}},
      {"parameters", {{"eta", 0.9}}}, {"parameter", "eta"},    {"branches", Json::array()}};
  for (int i = 0; i < count; ++i) {
    const auto point = [&](double eta) {
      return Json{{"value", eta},
                  {"state", {0.1 * i + eta, 0.0}},
                  {"multipliers", {{-1.0, 0.0}, {-0.8, 0.0}}},
                  {"impacts", 1},
                  {"stable", true},
                  {"admissible", true}};
    };
    Json special = point(0.85);
    special.update({{"type", "PD"}, {"label", fmt::format("PD{}", i + 1)}, {"after_point", 0}});
    result["branches"].push_back({{"id", i + 1},
                                  {"parent", nullptr},
                                  {"period", 1 + i % 3},
                                  {"stop", {{"reason", "reached_bound"}}},
                                  {"points", {point(0.8), point(0.9)}},
                                  {"special_points", {special}}});
  }
  return result;
}

std::set<std::string> titles(const Picture& picture) {
  std::set<std::string> list;
  for (const apps::Curve& curve : picture.curves)
    if (!curve.title.empty()) list.insert(curve.title);
  return list;
}

}  // namespace

TEST_CASE("a legend of very many curves leaves room for the axes and gives the number of omitted ones") {
  Picture picture;
  for (int i = 0; i < 200; ++i)
    picture.curves.push_back({.title = fmt::format("curve {}", i), .points = {{0.0, 1.0 * i, 0.0}, {1.0, 2.0, 0.0}}});
  picture.barriers.push_back({.vertical = false, .position = 0.9, .text = "barrier"});
  const Legend legend = legend_of(picture);
  CHECK(legend.rows <= 9);
  CHECK(legend.titles + legend.left_out == 200);
  CHECK(legend.titles + 2 <= legend.rows * legend.columns);
  const std::string script = gnuplot_script(picture, "svg");
  CHECK_THAT(script, Contains(fmt::format("title 'and {} more'", legend.left_out)) && Contains("title 'barrier'"));
  CHECK_THAT(script, Contains("'curve 0'") && !Contains("'curve 199'"));
  picture.curves.resize(20);
  CHECK(legend_of(picture).left_out == 0);
  CHECK_THAT(gnuplot_script(picture, "svg"), Contains("'curve 19'") && !Contains(" more'"));
}

TEST_CASE("the legend of the basins has the rows that its entries need below the axis label") {
  // Fixed: three entries of this length do not fit side by side, and the second row was printed over the axis label.
  Picture picture;
  for (const char* title : {"z = 56/12: 61.9 ± 0.8 %", "z = 4/1: 38.1 ± 0.8 %"})
    picture.curves.push_back({.title = title, .points = {{0.0, 1.0, 0.0}, {1.0, 2.0, 0.0}}});
  picture.barriers.push_back({.vertical = true, .position = -0.5, .text = "barrier x = r = -0.5"});
  CHECK(legend_of(picture).columns == 2);
  CHECK(legend_of(picture).rows == 2);
  // One long barrier entry has the same effect; short entries fit into three columns.
  picture.curves.front().title = "z = 5/2";
  CHECK(legend_of(picture).rows == 1);
  picture.barriers.front().text = "barrier x = r = -0.512345";
  CHECK(legend_of(picture).rows == 2);
}

TEST_CASE("a barrier is named in the legend where its words cover nothing") {
  Picture picture;
  picture.curves.push_back({.title = "x", .points = {{0.0, 1.0, 0.0}, {1.0, 2.0, 0.0}}});
  picture.barriers.push_back({.vertical = true, .position = 0.9, .text = "barrier x = r = 0.9"});
  const std::string script = gnuplot_script(picture, "svg");
  CHECK_THAT(script, Contains("title 'barrier x = r = 0.9'") && !Contains("set label"));
  CHECK_THAT(draw(picture, "svg"), Contains("barrier x = r = 0.9"));
}

TEST_CASE("words without a mark are drawn without one") {
  Picture picture;
  picture.curves.push_back({.points = {{0.0, 1.0, 0.0}, {1.0, 2.0, 0.0}}});
  picture.labels.push_back({.x = 0.5, .y = 1.2, .text = "1/2", .mark = no_mark, .placed = true});
  CHECK_THAT(gnuplot_script(picture, "svg"), Contains("set label '1/2'") && !Contains(" point "));
}

TEST_CASE("words in a crowd are left out where they would cover others") {
  std::vector<Label> labels;
  for (int i = 0; i < 100; ++i) labels.push_back({.x = 0.5 + 1e-4 * i, .y = 0.5, .text = fmt::format("PD{} 0.5", i)});
  const std::array<double, 2> range = {0.0, 1.0};
  const auto count_free = [](const std::vector<LabelPlace>& places) {
    return std::count_if(places.begin(), places.end(), [](const LabelPlace& place) { return place.free; });
  };
  const auto places = label_places(labels, range, range);
  CHECK(count_free(places) > 0);
  CHECK(count_free(places) <= 20);
  labels.resize(3);
  CHECK(count_free(label_places(labels, range, range)) == 3);
}

TEST_CASE("a few branches have separate colours and many have those of their periods") {
  CHECK(titles(picture_of(branches_of(3), "branch")) ==
        std::set<std::string>{"branch 1: period 1, stable", "branch 2: period 2, stable", "branch 3: period 3, stable"});
  const Picture many = picture_of(branches_of(40), "branch");
  CHECK(titles(many) == std::set<std::string>{"period 1", "period 2", "period 3", "stable", "PD, period doubling"});
  CHECK(std::all_of(many.labels.begin(), many.labels.end(), [](const Label& label) { return label.placed; }));
  CHECK(titles(picture_of(branches_of(40), "multipliers")) == std::set<std::string>{"period 1", "period 2", "period 3"});
  CHECK(titles(picture_of(branches_of(3), "multipliers")).count("branch 2: period 2") == 1);
}

TEST_CASE("special points whose multipliers coincide have one label") {
  const Picture few = picture_of(branches_of(3), "multipliers");
  REQUIRE(few.labels.size() == 1);
  CHECK(few.labels.front().text == "PD1 PD2 PD3");
  const Picture many = picture_of(branches_of(40), "multipliers");
  REQUIRE(many.labels.size() == 1);
  CHECK(many.labels.front().text == "PD1 PD2 PD3 and 37 more");
}

TEST_CASE("a table of many branches is drawn in the colours of their periods") {
  Table table{{"branch", "parent", "label", "period", "impacts", "eta", "x", "v", "stable", "admissible"}, {}};
  for (int i = 1; i <= 30; ++i)
    for (const char* eta : {"0.8", "0.9"})
      table.rows.push_back({std::to_string(i), "", "", std::to_string(1 + i % 2), "1", eta, "1", "0", "yes", "yes"});
  CHECK(titles(picture_of(table)) == std::set<std::string>{"period 1, stable", "period 2, stable"});
}

TEST_CASE("the line of a trajectory is broken where a hard impact reverses the velocity") {
  const Table table{
      {"tau", "x", "v"},
      {{"0", "0.7", "1"}, {"0.1", "0.8", "1.01"}, {"0.2", "0.9", "1.02"}, {"0.3", "0.92", "-1.0"}, {"0.4", "0.8", "-1.01"}}};
  const auto breaks = [](const apps::Curve& curve) {
    return std::count_if(curve.points.begin(), curve.points.end(), [](const auto& point) { return std::isnan(point[0]); });
  };
  const Picture phase = picture_of(table, "x", {"v"});
  REQUIRE(phase.curves.size() == 1);
  CHECK(breaks(phase.curves.front()) == 1);
  CHECK(std::isnan(phase.curves.front().points[3][0]));
  const Picture time = picture_of(table);  // x is continuous where v jumps
  REQUIRE(time.curves.size() == 2);
  CHECK(breaks(time.curves[0]) == 0);
  CHECK(breaks(time.curves[1]) == 1);
}

TEST_CASE("an interrupted skeleton gives no empty pictures and one line reports the omitted ones") {
  Json result = branches_of(2);
  CHECK(pictures_for(result) == std::vector<std::string>{"branch", "multipliers", "skeleton"});
  result["branches"] = Json::array();
  CHECK(pictures_for(result).empty());
  result.update({{"schema", "graze.diagram/1"}, {"rows", Json::array()}});
  CHECK(pictures_for(result).empty());

  std::vector<CutOff> left(1454, {0, "seed", was_interrupted});
  left.push_back({3, "PD1", was_interrupted});
  left.push_back({4, "GR2", std::string("families of several times its period: ") + was_interrupted});
  left.push_back({5, "PD2", "period 32 is above the limit, 16"});
  const Json search = {{"max_period", 16},
                       {"values", 121},
                       {"spacing", 0.0025},
                       {"starts", 128},
                       {"unstable", {{"max_period", 0}, {"values", 0}}}};
  const std::string text = skeleton_text(search, 730, {}, left, "eta");
  CHECK_THAT(text, Contains("1454 ways from seeds (two from each) and 2 special points: it was interrupted\n") &&
                       Contains("PD2 of branch 5: period 32"));
  CHECK(text.find(was_interrupted) == text.rfind(was_interrupted));
}

TEST_CASE("no pictures are drawn of an orbit or a point that was not found") {
  CHECK(pictures_for({{"schema", "graze.orbit/1"}, {"orbit", nullptr}}).empty());
  CHECK(pictures_for({{"schema", "graze.orbit/1"}, {"orbits", Json::array()}}).empty());
  CHECK(pictures_for({{"schema", "graze.orbit/1"}, {"orbit", {{"period", 1}}}}).size() == 2);
  CHECK(pictures_for({{"schema", "graze.point/1"}, {"special_point", nullptr}}).empty());
}

TEST_CASE("an unknown kind of picture is refused with a sorted list") {
  CHECK_THROWS_WITH(picture_of(branches_of(2), "foo"),
                    "of graze.branch/1 there is no kind of picture \"foo\"; choose one of branch, multipliers, skeleton");
}
