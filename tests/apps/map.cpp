// SPDX-License-Identifier: GPL-3.0-or-later
// graze map: its results in all formats, and misuse.
#include "graze_program.hpp"

#include <graze/apps/map/map_chunk.hpp>
#include <graze/apps/map/map_report.hpp>
#include <graze/apps/pictures/map_colours.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/table.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <set>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using namespace std::string_literals;
using Catch::Matchers::Contains;

namespace {

Outcome run(std::vector<std::string> more, const std::string& id = "hertz-damped") { return call("map", id, std::move(more)); }

const std::vector<std::string> small = {"--param", "eta:0.69:0.74:6", "--param", "r:1.9:2.1:3"};

std::vector<std::string> with(const std::vector<std::string>& more) {
  std::vector<std::string> all = small;
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

}  // namespace

TEST_CASE("map: JSON, table, HDF5 and h5py agree") {
  const TemporaryFolder folder;
  const std::string h5 = folder.file("m.h5"), csv = folder.file("m.csv");
  const Json json =
      json_of(run(with({"--follow", "both", "--h5", h5, "--csv", csv, "--json", "-", "--y", "max(x)", "--y", "v/eta"})));
  CHECK(json["schema"] == "graze.map/1");
  CHECK(json["status"] == "done");
  CHECK(json["options"]["columns"] == Json({{"parameter", "eta"}, {"from", 0.69}, {"to", 0.74}, {"count", 6}}));
  REQUIRE(json["layers"].size() == 2);
  CHECK(json["layers"][1]["follow"] == "down");
  std::set<std::string> types;
  std::size_t counted = 0;
  for (const Json& row : json["layers"][0]["type"])
    for (const Json& type : row) types.insert(type);
  for (const Json& kind : json["layers"][0]["counts"]) counted += kind["points"].get<std::size_t>();
  CHECK(types == std::set<std::string>{"chaotic", "periodic"});
  CHECK(counted == 18);

  const Table table = parse_csv(read_file(csv), csv);
  REQUIRE(table.rows.size() == 36);
  CHECK(table.columns[1] == "r");
  CHECK(table.rows[11][6] == Json(json["layers"][1]["lambda_1"][0][5]).dump());  // row by row, and within each layer by layer

  // Debian's own python3 has Debian's h5py, even if another python3 is first on PATH.
  const Outcome seen =
      run_shell("sh -c 'for python in python3 /usr/bin/python3; do "
                "$python -c \"import h5py\" 2> /dev/null && exec $python \"$0\" \"$1\"; done; exit 77' '" GRAZE_SOURCE_DIR
                "/tests/apps/read_map.py' '" +
                h5 + "'");
  if (seen.code == 77) {
    skip_test("python3-h5py is not installed: the HDF5 file was not read by it");
    return;
  }
  INFO(seen.err);
  REQUIRE(seen.code == 0);
  const Json python = Json::parse(seen.out);
  CHECK(python["schema"] == "graze.map/1");
  CHECK(python["units"] == "dimensionless");
  CHECK(python["options"] == json["options"]);
  for (const auto& [name, value] : json["parameters"].items()) CHECK(python["parameters"][name] == value);
  CHECK(python["dimensions"] == Json({"/layer", "/r", "/eta"}));
  CHECK(python["eta"].size() == 6);
  CHECK(python["eta"][5] == 0.74);
  CHECK(python["r"][0] == 1.9);
  CHECK(python["start"] == Json::parse("[[null, null], [null, null]]"));
  CHECK(python["follow"] == Json({"up", "down"}));
  CHECK(python["flags"] == Json({{0, 1, 2, 3, 4}, python["names"]}));  // as CF requires
  CHECK(python["filters"] == Json::parse(R"(["gzip", true, [1, 3, 6]])"));
  for (std::size_t layer = 0; layer < 2; ++layer) {
    for (const char* name : {"type", "lambda_1", "standard_error", "state"})
      CHECK(python[name][layer] == json["layers"][layer][name]);
    CHECK(python["y"]["max(x)"][layer] == json["layers"][layer]["y"]["max(x)"]);
    CHECK(python["y"]["v_over_eta"][layer] == json["layers"][layer]["y"]["v/eta"]);
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 6; ++column) {
        const Json& period = json["layers"][layer]["period"][row][column];
        CHECK(python["period"][layer][row][column] == (period.is_null() ? Json(0) : period));
      }
  }
}

TEST_CASE("map: its points agree with lyapunov at the same parameters") {
  const Json map = json_of(run(with({"--json", "-"})))["layers"][0];
  for (const auto& [row, column] : {std::pair{0, 0}, {1, 3}, {2, 5}}) {
    const std::string eta = fmt::format("eta={}", 0.69 + column * 0.01), r = fmt::format("r={}", 1.9 + row * 0.1);
    const Json one = json_of(call({"lyapunov", problem("hertz-damped"), "--set", eta, "--set", r, "--quiet", "--json", "-"}));
    INFO(eta << " " << r);
    CHECK(map["type"][row][column] == one["attractor"]["type"]);
    CHECK(map["period"][row][column] == one["attractor"]["period"]);
    CHECK(map["impacts"][row][column] == one["attractor"]["impacts"]);
    // Chaotic: two independent averages. Periodic: one orbit; Newton's 1e-12 gives its multipliers an error of 1e-9.
    const double error = std::hypot(map["standard_error"][row][column].get<double>(), one["standard_errors"][0].get<double>());
    const double bound = map["type"][row][column] == "chaotic" ? 5.0 * error : 1e-9;
    CHECK(std::abs(map["lambda_1"][row][column].get<double>() - one["exponents"][0].get<double>()) < bound);
  }
}

TEST_CASE("map: several starts are layers and a start inside a barrier affects only its point") {
  const std::vector<std::string> options = {"--param", "eta:0.7:0.8:3", "--param", "r:1:3:3", "--start", "0,0",
                                            "--start", "1.5,0.2",       "--json",  "-",       "--set",   "k_r=0.8"};
  const Json json = json_of(run(options, "newton-elastic"));
  REQUIRE(json["layers"].size() == 2);
  CHECK(json["layers"][1]["start"] == Json({1.5, 0.2}));
  CHECK(json["layers"][0]["type"][0][0] != "inadmissible");
  CHECK(json["layers"][1]["type"][0][0] == "inadmissible");
  CHECK(json["layers"][1]["lambda_1"][0][0].is_null());
  CHECK(json["layers"][1]["type"][2][0] != "inadmissible");
}

TEST_CASE("map: pictures have a cell per point and a legend of the occurring types") {
  const TemporaryFolder folder;
  const std::string h5 = folder.file("m.h5"), json = folder.file("m.json");
  REQUIRE(run(with({"--follow", "both", "--h5", h5, "--json", json, "--plot", folder.file("m.png")})).code == 0);
  CHECK(read_file(folder.file("m.png")).size() > 2000);
  const Json result = Json::parse(read_file(json));
  const Picture picture = picture_of(result);
  REQUIRE(picture.cells);
  CHECK(picture.cells->colour.size() == 18);
  CHECK(picture.beside.size() == 1);
  std::vector<std::string> titles;
  for (const Curve& curve : picture.curves) titles.push_back(curve.title);
  CHECK(std::count(titles.begin(), titles.end(), "chaotic") == 1);
  CHECK(std::count(titles.begin(), titles.end(), "undecided") == 0);
  CHECK(std::count(titles.begin(), titles.end(), "z = 1/1") + std::count(titles.begin(), titles.end(), "impactless") > 0);
  CHECK(picture.common_legend);
  const Picture exponent = picture_of(result, "exponent");
  CHECK(exponent.curves.empty());
  CHECK_THAT(gnuplot_script(exponent, "svg"), Contains("set palette defined (-") && Contains(" 0 '#f7f7f7'"));
  for (std::size_t i = 0; i < 18; ++i) {  // warm colours where the exponent is positive
    const bool positive = result["layers"][0]["lambda_1"][i / 6][i % 6].get<double>() > 0.0;
    const std::string colour = exponent.cells->colours[static_cast<std::size_t>(exponent.cells->colour[i])];
    CHECK((colour.substr(1, 2) > colour.substr(5, 2)) == positive);  // more red than blue
  }
  for (const char* kind : {"attractors", "exponent"})
    CHECK(call({"plot", h5, "--plot-kind", kind, "-o", folder.file("p.svg")}).code == 0);
  // The same picture from the file and from JSON.
  CHECK(call({"plot", h5, "-o", folder.file("a.svg")}).code == 0);
  CHECK(call({"plot", json, "-o", folder.file("b.svg")}).code == 0);
  CHECK(read_file(folder.file("a.svg")) == read_file(folder.file("b.svg")));
}

TEST_CASE("map: any layer can be drawn") {
  const TemporaryFolder folder;
  const std::string h5 = folder.file("m.h5"), json = folder.file("m.json"), png = folder.file("m.png");
  const std::vector<std::string> layers = {"--follow", "both", "--start", "0,0", "--start", "0.5,0", "--start", "1,0"};
  std::vector<std::string> options = with(layers);
  options.insert(options.end(), {"--h5", h5, "--json", json, "--plot", folder.file("m.svg"), "--layer", "5"});
  REQUIRE(run(options).code == 0);
  CHECK_THAT(read_file(folder.file("m.svg")), Contains("layer 5: rows followed down, from (1, 0)") && !Contains("layer 4"));
  CHECK(call({"plot", json, "--layer", "4", "--layer", "1", "-o", folder.file("p.svg")}).code == 0);
  CHECK_THAT(read_file(folder.file("p.svg")), Contains("layer 4: ") && Contains("layer 1: ") && !Contains("layer 0"));
  CHECK(call({"plot", h5, "-o", folder.file("p.svg")}).code == 0);
  CHECK_THAT(read_file(folder.file("p.svg")), Contains("(the first 4 of 6 layers; --layer draws others)"));
  const auto misuse = [&](std::vector<std::string> more) {
    more.insert(more.begin(), "plot");
    more.insert(more.end(), {"-o", png});
    const Outcome outcome = call(more);
    CHECK(outcome.code == 2);
    return outcome.err;
  };
  CHECK_THAT(misuse({h5, "--layer", "6"}), Contains("--layer 6: this map has 6 layers; give one from 0 to 5"));
  CHECK_THAT(misuse({json, "--layer", "one"}), Contains("--layer one: must be a whole number"));
  CHECK_THAT(misuse({h5, "--layer", "0", "--layer", "1", "--layer", "2", "--layer", "3", "--layer", "4"}),
             Contains("--layer is given 5 times; a picture shows 4 layers at most"));
  CHECK_THAT(misuse({folder.write("t.csv", "a,b\n1,2\n"), "--layer", "0"}), Contains("--layer is for maps"));
  CHECK_THAT(misuse({folder.write("o.json", "{\"schema\": \"graze.orbit/1\"}"), "--layer", "0"}), Contains("this is none"));
  CHECK_THAT(run(with({"--layer", "1", "--plot", png})).err, Contains("this map has one layer, 0; leave --layer away"));
  CHECK_THAT(run(with({"--layer", "0"})).err, Contains("give --plot FILE or --out DIR too"));
}

TEST_CASE("map: a picture explains its cells without attractor") {
  Json result =
      json_of(run({"--param", "eta:0.7:0.8:3", "--param", "r:1:3:3", "--start", "1.5,0.2", "--json", "-"}, "newton-elastic"));
  Json& layer = result["layers"][0];
  for (std::size_t column = 0; column < 3; ++column) {
    layer["type"][2][column] = "not_run";
    layer["lambda_1"][2][column] = nullptr;
  }
  for (const std::string kind : {"attractors", "exponent"}) {
    const Picture picture = picture_of(result, kind);
    std::vector<std::string> titles;
    for (const Curve& curve : picture.curves) titles.push_back(curve.title);
    CHECK(std::count(titles.begin(), titles.end(), "start inside the barrier") == 1);
    CHECK(std::count(titles.begin(), titles.end(), "not computed") == 1);
    CHECK(std::count(titles.begin(), titles.end(), "lost") == 0);
    CHECK_THAT(picture.subtitle, Contains("incomplete: 33 % of the points are not computed"));
    CHECK(picture.cells->colour[0] >= 0);
    CHECK(picture.cells->colour[8] == -1);
    CHECK(draw(picture, "svg").size() > 2000);
  }
}

TEST_CASE("map: the most frequent z have separate colours and the others are coloured by period") {
  std::vector<MapPoint> points;
  for (int impacts = 1; impacts <= 8; ++impacts)
    for (int k = 0; k < 10 - impacts; ++k) {
      MapPoint point;
      point.type = MapType::periodic;
      point.period = 1;
      point.impacts = impacts;
      point.lambda_1 = -0.1 * impacts;
      points.push_back(point);
    }
  points.back().period = 11;
  const MapColours colours = attractor_colours(points);
  std::vector<std::string> titles;
  for (const Curve& curve : colours.legend) titles.push_back(curve.title);
  CHECK(titles ==
        std::vector<std::string>{"z = 1/1", "z = 2/1", "z = 3/1", "z = 4/1", "z = 5/1", "other z of period 1", "z = 8/11"});
  CHECK(colours.index(points[0]) != colours.index(points[10]));
  CHECK(colours.scale.empty());
  points.back().lambda_1 = -HUGE_VAL;  // it sticks
  CHECK(attractor_colours(points).legend.back().title == "z = ∞/11 (sticks)");
  const MapColours exponents = exponent_colours(points);
  REQUIRE(exponents.legend.size() == 1);
  CHECK(exponents.legend[0].title == "-infinity (sticks)");
  CHECK(exponents.scale.front().value == Approx(-0.8));
  CHECK(exponents.index(points[0]) != exponents.index(points.back()));
}

TEST_CASE("map: for a sticking motion all formats have the exponent minus infinity") {
  const TemporaryFolder folder;
  const std::string h5 = folder.file("m.h5"), json = folder.file("m.json");
  const Outcome outcome = run(
      {"--set", "k_r=0.5", "--param", "eta:0.3:0.9:7", "--param", "r:-0.5:0.5:4", "--h5", h5, "--json", json}, "newton-elastic");
  REQUIRE(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("z = ∞/1"));
  const Json layer = Json::parse(read_file(json))["layers"][0];
  CHECK(layer["sticking"][0][0] == true);
  CHECK(layer["impacts"][0][0] > 1);
  CHECK(layer["lambda_1"][0][0].is_null());
  CHECK(layer["sticking"][3][6] == false);
  CHECK(layer["counts"][0]["points"].is_number());
  for (const std::string kind : {"attractors", "exponent"}) {
    for (const std::string& from : {h5, json})
      REQUIRE(call({"plot", from, "--plot-kind", kind, "-o", from + "." + kind + ".svg"}).code == 0);
    CHECK(read_file(h5 + "." + kind + ".svg") == read_file(json + "." + kind + ".svg"));
  }
}

TEST_CASE("map: a change of any byte of a chunk is detected") {
  MapPlan plan;
  plan.problem = make_problem("linear", "hertz");
  plan.grid = {{"eta", 0.7, 0.8, 2}, {"r", 1.0, 2.0, 3}};
  MapChunk chunk{1, 1, std::vector<MapPoint>(2)};
  chunk.points[0] = {MapType::periodic, 3, 2, -0.05, 0.0, Vector{{1.0, -2.0}}, {}};
  chunk.points[1] = {MapType::chaotic, 0, 0, 0.1, 1e-3, Vector{{0.5, 0.25}}, {}};
  const std::string bytes = chunk_bytes(chunk, plan, 42);
  const auto back = chunk_from(bytes, plan, 42, 1);
  REQUIRE(back);
  CHECK(back->points[0].period == 3);
  CHECK(back->points[0].impacts == 2);
  CHECK(back->points[1].type == MapType::chaotic);
  CHECK(back->points[1].lambda_1 == 0.1);
  CHECK(back->points[1].state[1] == 0.25);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 16);
    CHECK_FALSE(chunk_from(damaged, plan, 42, 1));
    CHECK_FALSE(chunk_from(bytes.substr(0, i), plan, 42, 1));
  }
  CHECK_FALSE(chunk_from(bytes, plan, 43, 1));  // of another run
  CHECK_FALSE(chunk_from(bytes, plan, 42, 0));  // of other rows
}

TEST_CASE("map: a damaged file is named with its damaged dataset") {
  const TemporaryFolder folder;
  const std::string h5 = folder.file("m.h5"), python = "/usr/bin/python3";
  REQUIRE(run(with({"--h5", h5})).code == 0);
  const std::string whole = read_file(h5);
  const auto plotted = [&] {
    const Outcome outcome = call({"plot", h5, "-o", folder.file("x.png")});
    CHECK(outcome.code == 2);
    CHECK_THAT(outcome.err, Contains("graze plot: " + h5 + ": this ") && Contains("; compute the map anew"));
    return outcome.err;
  };
  const auto replaced = [&](const std::string& text, const std::string& other) {
    std::string bytes = whole;
    for (std::size_t at = bytes.find(text); at != std::string::npos; at = bytes.find(text, at + 1))
      bytes.replace(at, text.size(), other);
    CHECK(bytes != whole);
    folder.write("m.h5", bytes);
    return plotted();
  };
  CHECK_THAT(replaced("lambda_1\0"s, "lambda_x\0"s), Contains("its dataset \"lambda_1\" is missing"));
  CHECK_THAT(replaced("\"count\":3", "\"count\":4"), Contains("\"attractor\" has 1 x 3 x 6 values and should have 1 x 4 x 6"));
  folder.write("m.h5", whole.substr(0, whole.size() / 2));
  CHECK_THAT(plotted(), Contains("this HDF5 file is truncated or damaged"));
  folder.write("m.h5", whole);
  if (run_shell(python + " -c \"import h5py; h5py.File('" + h5 + "', 'r+')['attractor'][...] = 200\"").code != 0) {
    skip_test("python3-h5py is not installed: a wrong attractor was not tested");
    return;
  }
  CHECK_THAT(plotted(), Contains("its dataset \"attractor\" holds a 200"));
}

TEST_CASE("map refuses invalid options") {
  const TemporaryFolder folder;
  const auto misuse = [](const std::vector<std::string>& more, const std::string& id = "hertz-damped") {
    const Outcome outcome = run(more, id);
    INFO(outcome.err);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    return outcome.err;
  };
  CHECK_THAT(misuse({}), Contains("--param is not given; a map is over two parameters"));
  CHECK_THAT(misuse({"--param", "eta:0.7:0.8:3"}), Contains("--param is given 1 time"));
  CHECK_THAT(misuse({"--param", "eta:0.7:0.8", "--param", "r:1:2:3"}), Contains("--param eta:0.7:0.8: must be NAME:A:B:N"));
  CHECK_THAT(misuse({"--param", "eta:0.7:0.8:0", "--param", "r:1:2:3"}), Contains("whole number >= 1"));
  CHECK_THAT(misuse({"--param", "eta:0.8:0.7:3", "--param", "r:1:2:3"}), Contains("A:B:N needs A < B; A is 0.8, B is 0.7"));
  CHECK_THAT(misuse({"--param", "eta:0.7:0.8:3", "--param", "eta:1:2:3"}), Contains("both parameters of the map are eta"));
  CHECK_THAT(misuse({"--param", "eta:0:0.8:3", "--param", "r:1:2:3"}), Contains("--param eta:0:0.8:3: parameter eta is 0"));
  CHECK_THAT(misuse({"--param", "eta:0.7:0.8:99999999999", "--param", "r:1:2:3"}),
             Contains("--param eta:0.7:0.8:99999999999: the number of values must be a whole number >= 1 and <= 2147483647"));
  CHECK_THAT(misuse({"--param", "eta:nan:0.8:3", "--param", "r:1:2:3"}),
             Contains("--param eta:nan:0.8:3: must be NAME:A:B:N, N values from A to B, for example eta:0.65:0.95:200"));
  CHECK_THAT(misuse({"--param", "etta:0.7:0.8:3", "--param", "r:1:2:3"}),
             Contains("--param etta:0.7:0.8:3: there is no") && Contains("did you mean \"eta\"?"));
  CHECK_THAT(misuse({"--param", "eta:0.7:0.8:3", "--param", "k_r:0:1:3"}), Contains("belongs to the newton contact law"));
  CHECK_THAT(misuse(with({"--start", "1"})), Contains("--start 1: must be two numbers x,v"));
  CHECK_THAT(misuse(with({"--start", "9,0"}), "newton-elastic"), Contains("--start") && Contains("x <= r"));
  for (const char* start : {"nan,0", "0,inf"})
    CHECK_THAT(misuse(with({"--start", start})),
               Contains(std::string("--start ") + start + ": the state holds a value that is not a finite number"));
  CHECK_THAT(misuse(with({"--follow", "sideways"})), Contains("--follow sideways"));
  CHECK_THAT(misuse(with({"--standard-error", "0"})), Contains("--standard-error is 0; allowed is > 0"));
  CHECK_THAT(misuse(with({"--transient", "50"})), Contains("--transient is of rows that are followed; give --follow"));
  CHECK_THAT(misuse(with({"--plot-kind", "exponent"})), Contains("--plot-kind exponent: there is no picture; give --plot"));
  CHECK_THAT(misuse(with({"--chunk", "0"})), Contains("--chunk 0"));
  CHECK_THAT(misuse(with({"--resume", folder.file("none")})), Contains("no such folder"));
  CHECK_THAT(misuse(with({"--h5", folder.file("none/m.h5")})), Contains("there is no folder"));
  CHECK_THAT(misuse({"--param", "eta:0.7:0.8:40000", "--param", "r:1:2:40000"}), Contains("more than a thousand million"));
  CHECK_THAT(misuse({"--param", "eta:0.7:0.8:2000", "--param", "r:1:2:2000", "--json", folder.file("j")}),
             Contains("points are too many for it, a million are allowed"));
  CHECK(folder.files() == 0);
  folder.write("x.h5", "this is none");
  const Outcome outcome = call({"plot", folder.file("x.h5"), "-o", folder.file("x.png")});
  CHECK(outcome.code == 2);
  CHECK_THAT(outcome.err, Contains("this is not an HDF5 file"));
}
