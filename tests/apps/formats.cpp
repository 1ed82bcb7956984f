// SPDX-License-Identifier: GPL-3.0-or-later
// JSON, CSV, tables, files and gnuplot scripts.
#include "graze_program.hpp"

#include <graze/apps/console/output_file.hpp>
#include <graze/apps/drawing/label_places.hpp>
#include <graze/apps/drawing/raster.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/table.hpp>

#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

TEST_CASE("JSON numbers read back to the same double") {
  std::mt19937_64 random(7);
  Json numbers = Json::array();
  for (int i = 0; i < 2000; ++i) {
    double value = 0.0;
    const std::uint64_t bits = random();
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) numbers.push_back(value);
  }
  for (const double value : {0.1, 5e-324, std::numeric_limits<double>::max(), -0.0, 1.0, 0.919542643087348})
    numbers.push_back(value);
  const Json back = Json::parse(pretty({{"numbers", numbers}}))["numbers"];
  REQUIRE(back.size() == numbers.size());
  for (std::size_t i = 0; i < back.size(); ++i) CHECK(back[i].get<double>() == numbers[i].get<double>());
}

TEST_CASE("NaN and infinities are null in JSON") {
  const double infinity = std::numeric_limits<double>::infinity();
  CHECK(pretty(Json{{"a", std::nan("")}, {"b", -infinity}, {"c", {infinity, 1.0}}}).find("inf") == std::string::npos);
  CHECK(Json::parse(pretty(Json{{"a", -infinity}}))["a"].is_null());
}

TEST_CASE("pretty JSON is the same JSON") {
  const Json json = {{"text", "a \"b\"\n"},
                     {"list", {1, 2, 3}},
                     {"nested", {{{"x", {}}, {"y", Json::array()}}, {{"long", std::string(200, 'x')}}}},
                     {"empty", Json::object()}};
  CHECK(Json::parse(pretty(json)) == json);
}

TEST_CASE("short JSON values and lists of numbers are on one line") {
  const Json fits = {{"a", {1, Json::array({Json::array({2, "x]\\\""})})}}};
  CHECK(pretty(Json{{"fits", fits}}) == "{\n  \"fits\": " + fits.dump() + "\n}\n");
  const std::vector<double> numbers(100, 0.25);
  CHECK(pretty(Json{{"numbers", numbers}}) == "{\n  \"numbers\": " + Json(numbers).dump() + "\n}\n");
  // At most 110 characters on a line, with indentation, without the name.
  for (const std::size_t letters : {96U, 97U}) {
    const Json list = {{{"b", {std::string(letters, 'x')}}}};
    REQUIRE(list.dump().size() == letters + 12);
    const std::string text = pretty(Json{{"list", list}});
    const std::string x = Json(std::string(letters, 'x')).dump();
    CHECK(text ==
          "{\n  \"list\": " + (letters == 96U ? list.dump() : "[\n    {\n      \"b\": [" + x + "]\n    }\n  ]") + "\n}\n");
  }
  CHECK(pretty(Json{{"a", Json::array()}, {"b", nullptr}}) == "{\n  \"a\": [],\n  \"b\": null\n}\n");
  CHECK(pretty(Json::object()) == "{}\n");
  CHECK(pretty(Json(1.5)) == "1.5\n");
}

TEST_CASE("the head of a result names its model and can be turned into a problem again") {
  Problem p = load_problem(problem("beam-newton"));
  apply_settings(p, {"k_r=0.7"});
  const Json head = result_head("orbit/1", "orbit", p, {{"period", 1}});
  CHECK(head["schema"] == "graze.orbit/1");
  CHECK(head["command"] == "orbit");
  CHECK(head["parameters"].size() == 6);
  const Problem again = problem_of(Json::parse(pretty(head)));
  CHECK(again.system.name == p.system.name);
  CHECK(again.parameters == p.parameters);
  CHECK_THROWS_WITH(problem_of(Json{{"schema", "graze.orbit/1"}}), Contains("model"));
}

TEST_CASE("a CSV table reads back") {
  const Table table{{"a", "b"}, {{"1", "x,y"}, {"2", "he said \"no\"\nand left"}, {"", "3"}}};
  const Table back = parse_csv(csv(table), "t.csv");
  CHECK(back.columns == table.columns);
  CHECK(back.rows == table.rows);
  CHECK(parse_csv("a,b\r\n1,2\r\n", "t.csv").rows.front() == std::vector<std::string>{"1", "2"});
  CHECK_THROWS_WITH(parse_csv("a,b\n1\n", "t.csv"), Contains("t.csv:2") && Contains("1 cell in a table of 2 columns"));
  CHECK_THROWS_WITH(parse_csv("", "t.csv"), Contains("empty"));
}

TEST_CASE("a table for people has its numbers right-aligned") {
  CHECK(aligned({{"name", "value"}, {{"eta", "0.95"}, {"b", "-1"}}}, 0) == "name  value\neta    0.95\nb        -1\n");
}

TEST_CASE("a file is written completely or not at all") {
  const TemporaryFolder folder;
  const std::string file = folder.file("result.json");
  check_writable(file);
  CHECK(folder.files() == 0);
  CHECK_FALSE(write_whole(file, "new"));
  CHECK(read_file(file) == "new");
  CHECK(folder.files() == 1);
  std::filesystem::create_symlink(file, folder.file("link.json"));
  CHECK_FALSE(write_whole(folder.file("link.json"), "through the link"));
  CHECK(std::filesystem::is_symlink(folder.file("link.json")));
  CHECK(read_file(file) == "through the link");
}

TEST_CASE("a file that cannot be written is detected before the computation") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(check_writable(folder.file("none/result.json")), Contains("there is no folder"));
  CHECK_THROWS_WITH(check_writable(folder.file("")), Contains("it is a folder"));
  const std::string file = folder.write("file", "");
  CHECK_THROWS_WITH(check_writable(file + "/result.json"), Contains("cannot be written"));
  CHECK_THROWS_WITH(check_writable_folder("/proc"), Contains("/proc: no files can be made in this folder: "));
  CHECK_THROWS_WITH(make_folder(file), Contains("cannot be made as a folder"));
}

TEST_CASE("a full disk is reported in one sentence") {
  const std::optional<std::string> failure = write_whole("/dev/full", "x");
  REQUIRE(failure);
  CHECK_THAT(*failure, Contains("/dev/full: cannot be written: No space left on device"));
}

TEST_CASE("text in gnuplot scripts is quoted") {
  Picture picture;
  picture.title = "k_H isn't `date`";
  picture.subtitle = "second line";
  picture.curves.push_back({.title = "a", .points = {{0.0, 1.0, 0.0}, {std::nan(""), 0.0, 0.0}, {1.0, 2.0, 0.0}}});
  const std::string script = gnuplot_script(picture, "svg");
  CHECK_THAT(script, Contains("set title 'k_H isn''t `date`'.\"\\n\".'second line'"));
  CHECK_THAT(script, Contains("noenhanced"));
  CHECK_THAT(draw(picture, "svg"), Contains("k_H isn't `date`"));
}

TEST_CASE("every format of picture is drawn") {
  Picture picture;
  picture.curves.push_back({.title = "a", .points = {{0.0, 1.0, 0.0}, {1.0, 2.0, 0.0}}});
  CHECK(draw(picture, "png").substr(1, 3) == "PNG");
  CHECK(draw(picture, "pdf").substr(0, 4) == "%PDF");
  CHECK_THAT(draw(picture, "svg"), Contains("<svg"));
  CHECK_THROWS_WITH(draw(Picture{}, "png"), Contains("nothing to draw"));
}

TEST_CASE("a title too long for the picture is broken into lines") {
  Picture picture;
  picture.subtitle =
      "cantilever oscillator, hertz contact: b = 0.026, beta = 1.0285714, xi = 0.08, eta = 0.554, r = 0.079, k_H = 100, b_H = 0";
  picture.curves.push_back({.points = {{0.0, 1.0, 0.0}, {1.0, 2.0, 0.0}}});
  CHECK_THAT(gnuplot_script(picture, "png"), Contains("1.0285714,'.\"\\n\".'xi = 0.08"));
}

TEST_CASE("an axis does not show rounding") {
  Picture picture;
  picture.curves.push_back({.points = {{0.0, 2.0, 0.0}, {1.0, 2.0 + 1e-13, 0.0}}});
  const std::string script = gnuplot_script(picture, "png");
  CHECK_THAT(script, Contains("set xrange [*:*]") && Contains("set yrange [1.97"));
}

TEST_CASE("very many points are drawn as an image and none is lost") {
  Picture picture;
  Curve dots{.title = "dots", .stroke = Stroke::dots};
  for (int i = 0; i < 300000; ++i) dots.points.push_back({std::fmod(i * 0.618034, 1.0), std::fmod(i * 0.414214, 1.0), 0.0});
  CHECK(is_dense(dots));
  Raster raster({-1.0, 1.0}, {-1.0, 1.0});
  raster.paint(
      {.stroke = Stroke::dots, .size = 0.1, .points = {{0.0, 0.0, 0.0}, {1.0, 1.0, 0.0}, {-1.0, -1.0, 0.0}, {2.0, 0.0, 0.0}}});
  CHECK(raster.painted() == 3);
  Raster line({0.0, 1.0}, {0.0, 1.0});
  line.paint({.size = 1.0, .points = {{-1.0, 0.5, 0.0}, {1e9, 0.5, 0.0}, {std::nan(""), 0.0, 0.0}, {0.5, 0.9, 0.0}}});
  CHECK(line.painted() == 801);
  picture.curves.push_back(std::move(dots));
  CHECK(draw(picture, "png").substr(1, 3) == "PNG");
}

TEST_CASE("clouds of dots keep their order where one of them is an image and larger dots are larger there") {
  Picture picture;
  Curve below{.stroke = Stroke::dots, .colour = "#fdae6b", .size = 0.5}, above{.stroke = Stroke::dots, .size = 0.25};
  for (int i = 0; i < 13000; ++i) below.points.push_back({i * 1e-4, std::sin(i), 0.0});
  for (int i = 0; i < 900; ++i) above.points.push_back({i * 1e-3, 0.0, 0.0});
  picture.curves = {below, above};
  CHECK_FALSE(is_dense(above));
  CHECK_THAT(gnuplot_script(picture, "png"), !Contains("$curve1"));  // in the image too
  Raster raster({-1.0, 1.0}, {-1.0, 1.0});
  raster.paint({.stroke = Stroke::dots, .size = 0.5, .points = {{0.0, 0.0, 0.0}}});
  CHECK(raster.painted() == 9);
}

TEST_CASE("labels avoid curves and marks where there is room and have a white background") {
  Picture picture;
  picture.x_range = picture.y_range = {{0.0, 1.0}};
  picture.labels.push_back({.x = 0.5, .y = 0.5, .text = "PD1 0.5"});
  const auto place = [&] { return label_places(picture.labels, *picture.x_range, *picture.y_range, picture.curves).front(); };
  CHECK(place().up > 0.0);
  CHECK_FALSE(place().leftwards);
  picture.curves.push_back({.points = {{0.5, 0.5, 0.0}, {1.0, 0.6, 0.0}}});
  CHECK((place().up < 0.0 || place().leftwards));
  picture.labels.push_back({.x = 0.52, .y = 0.47, .text = ""});
  CHECK(place().leftwards);
  picture.labels.front().placed = true;
  CHECK_FALSE(place().leftwards);
  picture.labels.front().placed = false;
  picture.barriers.push_back({.vertical = false, .position = 0.9, .text = "barrier"});
  const std::string script = gnuplot_script(picture, "svg");
  CHECK_THAT(script, Contains("set style textbox opaque") && Contains("'PD1 0.5' at") && Contains("boxed"));
  CHECK(draw(picture, "svg").size() > 2000);
}

TEST_CASE("the table of a map is no picture unless columns are named") {
  const Table table{{"layer", "r", "eta", "type", "period", "impacts", "lambda_1", "standard_error", "x", "v"},
                    {{"0", "1", "0.7", "periodic", "1", "1", "-0.05", "0", "0.1", "0.2"},
                     {"0", "1", "0.8", "periodic", "1", "1", "-0.06", "0", "0.3", "0.2"}}};
  CHECK_THROWS_WITH(picture_of(table), Contains("give one of these, or name columns by --x and --y"));
  CHECK(picture_of(table, "eta", {"lambda_1"}).curves.size() == 1);
}

TEST_CASE("an image has four bytes per pixel from the lower left corner on") {
  Raster raster({-1.0, 1.0}, {0.0, 1.0}, 4, 2);
  raster.paint({.stroke = Stroke::dots, .colour = "#102030", .size = 0.1, .points = {{-0.9, 0.1, 0.0}}});
  raster.paint({.stroke = Stroke::dots, .colour = "#fffefd", .size = 0.1, .points = {{0.9, 0.9, 0.0}}});
  const Image image = raster.image();
  CHECK(image.columns == 4);
  CHECK(image.rows == 2);
  CHECK(image.first == std::array<double, 2>{-0.75, 0.25});
  CHECK(image.step == std::array<double, 2>{0.5, 0.5});
  REQUIRE(image.rgba.size() == 4 * 8);
  CHECK(image.rgba.substr(0, 4) == "\x10\x20\x30\xff");
  CHECK(image.rgba.substr(4 * 7, 4) == "\xff\xfe\xfd\xff");
  CHECK(image.rgba.substr(4, 4 * 6) == std::string(24, '\0'));

  // Cells around 0, 1, 2 and 5, 6, of 266 by 250 pixels each; the last one is empty.
  const Cells cells{{0.0, 1.0, 2.0}, {5.0, 6.0}, {"#010203", "#040506"}, {0, 1, 0, 1, 0, -1}};
  const Image field = image_of(cells);
  CHECK(field.columns == 3 * 266);
  CHECK(field.rows == 2 * 250);
  CHECK(field.first[0] == Approx(-0.5 + 0.5 / 266.0));
  CHECK(field.first[1] == Approx(4.5 + 0.5 / 250.0));
  const auto element = [&](std::size_t column, std::size_t row) { return field.rgba.substr(4 * (row * 798 + column), 4); };
  const std::string one = "\x01\x02\x03\xff", other = "\x04\x05\x06\xff";
  CHECK(element(0, 0) == one);
  CHECK(element(265, 249) == one);
  CHECK(element(266, 249) == other);
  CHECK(element(265, 250) == other);
  CHECK(element(531, 499) == one);
  CHECK(element(532, 499) == std::string(4, '\0'));
  CHECK(element(797, 499) == std::string(4, '\0'));
  CHECK(field.rgba.size() == 4 * 798 * 500);
}

TEST_CASE("points of a line that cannot be distinguished are left out") {
  Curve line;
  for (int i = 0; i <= 100000; ++i) line.points.push_back({i * 1e-5, 0.0, 0.0});
  const auto kept = thinned(line, {0.0, 1.0}, {-1.0, 1.0});
  CHECK(kept.size() > 1000);
  CHECK(kept.size() < 4000);
  CHECK(kept.front() == line.points.front());
  CHECK(kept.back() == line.points.back());
}

TEST_CASE("tables of graze are drawn according to their kind") {
  const Table branches{{"branch", "parent", "label", "period", "impacts", "eta", "x", "v", "stable", "admissible"},
                       {{"1", "", "", "1", "1", "0.9", "1", "0", "yes", "yes"},
                        {"1", "", "PD1", "1", "1", "0.85", "1.05", "0", "no", "yes"},
                        {"1", "", "", "1", "1", "0.8", "1.1", "0", "no", "yes"},
                        {"2", "PD1", "", "2", "2", "0.85", "1.05", "0", "yes", "yes"},
                        {"2", "PD1", "", "2", "2", "0.8", "1.2", "0", "yes", "yes"}}};
  const Picture picture = picture_of(branches);
  CHECK_THAT(picture.x_label, Contains("eta"));
  REQUIRE(picture.curves.size() == 3);
  CHECK(picture.curves[0].stroke == Stroke::solid);
  CHECK(picture.curves[1].stroke == Stroke::dashed);
  CHECK(picture.curves[1].points.front()[0] == 0.85);
  CHECK(picture.curves[2].colour != picture.curves[0].colour);
  REQUIRE(picture.labels.size() == 1);
  CHECK(picture.labels.front().text == "PD1");
  const Picture chosen = picture_of(branches, "x", {"v"});
  REQUIRE(chosen.curves.size() == 3);
  CHECK(chosen.x_label == "x");
  CHECK(chosen.y_label == "v");
  CHECK(chosen.curves[1].stroke == Stroke::dashed);
  CHECK(chosen.curves[1].points == std::vector<std::array<double, 3>>{{1.05, 0.0, 0.0}, {1.1, 0.0, 0.0}});
  CHECK(chosen.curves[2].colour != chosen.curves[0].colour);
  const Picture several = picture_of(branches, "eta", {"x", "v"});
  REQUIRE(several.curves.size() == 2);
  CHECK(several.y_label == "x, v");
  CHECK(std::isnan(several.curves.front().points[3][0]));  // between the branches
  CHECK(picture_of(Table{{"phase", "speed"}, {{"1", "2"}}}).curves.front().stroke == Stroke::dots);
  CHECK(picture_of(Table{{"x", "v"}, {{"1", "2"}, {"3", "4"}}}, "v", {"x"}).curves.front().stroke == Stroke::dots);
}

TEST_CASE("tables of attractors are drawn as dots like the same results in JSON") {
  const Table sweep{{"eta", "direction", "attractor", "period", "impacts", "exponent1", "exponent2", "x", "v"},
                    {{"0.7", "up", "periodic", "2", "1", "-0.05", "-0.05", "1.5", "0.1"},
                     {"0.7", "up", "periodic", "2", "1", "-0.05", "-0.05", "-1.5", "0.2"},
                     {"0.8", "up", "chaotic", "", "", "0.1", "-0.2", "0.5", "0.3"},
                     {"0.8", "down", "chaotic", "", "", "0.1", "-0.2", "0.6", "0.3"}}};
  const Picture swept = picture_of(sweep);
  CHECK_THAT(swept.x_label, Contains("eta"));
  REQUIRE(swept.curves.size() == 4);  // for each direction one legend entry and its dots
  for (const Curve& curve : swept.curves) CHECK(curve.stroke == Stroke::dots);
  CHECK(swept.curves[0].title == "sweep down");
  CHECK(swept.curves[1].title == "sweep up");
  CHECK(swept.curves[2].points == std::vector<std::array<double, 3>>{{0.8, 0.6, 0.0}});
  CHECK(swept.curves[3].points == std::vector<std::array<double, 3>>{{0.7, 1.5, 0.0}, {0.7, -1.5, 0.0}, {0.8, 0.5, 0.0}});
  REQUIRE(swept.x_range);
  CHECK((*swept.x_range)[1] < 1.0);  // the dots of the legend lie outside the visible range
  for (const Curve& curve : picture_of(sweep, "eta", {"v"}).curves) CHECK(curve.stroke == Stroke::dots);

  const Table starts{{"x", "v", "attractor", "type", "period", "impacts"},
                     {{"0", "0", "1", "periodic", "3", "2"},
                      {"1", "0", "2", "chaotic", "", ""},
                      {"0", "1", "1", "periodic", "3", "2"},
                      {"1", "1", "", "lost", "", ""},
                      {"9", "1", "", "beyond the barrier", "", ""}}};
  const Picture basins = picture_of(starts);
  std::map<std::string, std::string> colours;  // by title
  std::map<std::string, std::size_t> dots;     // by colour
  for (const Curve& curve : basins.curves) {
    if (!curve.title.empty()) colours[curve.title] = curve.colour;
    if (curve.title.empty()) CHECK(curve.stroke == Stroke::dots);
    if (curve.title.empty()) dots[curve.colour] += curve.points.size();
  }
  CHECK(colours.size() == 3);
  CHECK(dots[colours["attractor 1: z = 2/3"]] == 2);
  CHECK(dots[colours["attractor 2: chaotic"]] == 1);
  CHECK(dots[colours["lost"]] == 1);
  CHECK_THROWS_WITH(picture_of(Table{starts.columns, {{"", "", "1", "periodic", "1", "1"}}}),
                    Contains("column x has no numbers"));
}

TEST_CASE("multipliers outside the picture are left out") {
  Json result = result_head("branch/1", "continue", load_problem(problem("hertz-damped")), Json::object());
  result["parameter"] = "eta";
  const Json multipliers = {{2.6, 0.0}, {0.5, 0.0}};
  const Json point = {{"value", 0.9}, {"state", {0.0, 0.0}}, {"multipliers", multipliers}};
  result["branches"] =
      Json::array({{{"id", 1}, {"period", 1}, {"points", Json::array({point})}, {"special_points", Json::array()}}});
  const Picture picture = picture_of(result, "multipliers");
  CHECK_THAT(picture.title, Contains("those beyond 2.5 are not shown"));
  REQUIRE(picture.curves.front().points.size() == 1);
  CHECK(picture.curves.front().points.front()[0] == 0.5);
}

TEST_CASE("nouns have singular and plural") {
  CHECK(counted(1, "contact") == "1 contact");
  CHECK(counted(0, "point") == "0 points");
}

TEST_CASE("the name of a picture must have a known ending") {
  CHECK_THROWS_WITH(check_picture_file("x.gif"), Contains(".png, .svg or .pdf"));
  CHECK_THROWS_WITH(check_picture_file("x"), Contains(".png, .svg or .pdf"));
  CHECK_NOTHROW(check_picture_file("x.PNG"));
}

TEST_CASE("an unknown picture is refused with the available ones") {
  CHECK_THROWS_WITH(picture_of(Json{{"a", 1}}), Contains("no \"schema\""));
  CHECK_THROWS_WITH(picture_of(Json{{"schema", "graze.models/1"}}), Contains("graze.models/1") && Contains("graze.branch/1"));
  CHECK_THROWS_WITH(picture_of(Json{{"schema", "graze.branch/1"}}, "brunch"), Contains("did you mean \"branch\""));
  CHECK_THROWS_WITH(picture_of(Json{{"schema", "graze.branch/1"}}),
                    Contains("the picture cannot be drawn") || Contains("which model"));
  const Table table{{"tau", "x", "name"}, {{"0", "1", "a"}, {"1", "2", "b"}}};
  CHECK(picture_of(table).curves.size() == 1);
  CHECK_THROWS_WITH(picture_of(table, "tua"), Contains("did you mean \"tau\""));
}
