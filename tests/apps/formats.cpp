// SPDX-License-Identifier: GPL-3.0-or-later
// JSON, CSV, tables, files and gnuplot scripts.
#include "graze_program.hpp"

#include <graze/apps/json.hpp>
#include <graze/apps/output_file.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/table.hpp>

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

TEST_CASE("a result's head names its model and can be turned into a problem again") {
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
  CHECK_THROWS_WITH(parse_csv("a,b\n1\n", "t.csv"), Contains("t.csv:2") && Contains("1 cells in a table of 2 columns"));
  CHECK_THROWS_WITH(parse_csv("", "t.csv"), Contains("empty"));
}

TEST_CASE("a table for people has its numbers to the right") {
  CHECK(aligned({{"name", "value"}, {{"eta", "0.95"}, {"b", "-1"}}}, 0) == "name  value\neta    0.95\nb        -1\n");
}

TEST_CASE("a file is written whole or not at all") {
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

TEST_CASE("a file that cannot be written is found out before") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(check_writable(folder.file("none/result.json")), Contains("there is no folder"));
  CHECK_THROWS_WITH(check_writable(folder.file("")), Contains("it is a folder"));
  const std::string file = folder.write("file", "");
  CHECK_THROWS_WITH(check_writable(file + "/result.json"), Contains("cannot be written"));
  CHECK_THROWS_WITH(make_folder(file), Contains("cannot be made as a folder"));
}

TEST_CASE("a full disk is told in one sentence") {
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

TEST_CASE("a picture's name must have an ending that is known") {
  CHECK_THROWS_WITH(check_picture_file("x.gif"), Contains(".png, .svg or .pdf"));
  CHECK_THROWS_WITH(check_picture_file("x"), Contains(".png, .svg or .pdf"));
  CHECK_NOTHROW(check_picture_file("x.PNG"));
}

TEST_CASE("a picture that there is none of is refused with what there is") {
  CHECK_THROWS_WITH(picture_of(Json{{"a", 1}}), Contains("no \"schema\""));
  CHECK_THROWS_WITH(picture_of(Json{{"schema", "graze.models/1"}}), Contains("graze.models/1") && Contains("graze.branch/1"));
  CHECK_THROWS_WITH(picture_of(Json{{"schema", "graze.branch/1"}}, "brunch"), Contains("did you mean \"branch\""));
  CHECK_THROWS_WITH(picture_of(Json{{"schema", "graze.branch/1"}}),
                    Contains("lacks what its picture needs") || Contains("which model"));
  const Table table{{"tau", "x", "name"}, {{"0", "1", "a"}, {"1", "2", "b"}}};
  CHECK(picture_of(table).curves.size() == 1);
  CHECK_THROWS_WITH(picture_of(table, "tua"), Contains("did you mean \"tau\""));
}
