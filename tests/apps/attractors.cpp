// SPDX-License-Identifier: GPL-3.0-or-later
// graze attractors: result, table, picture, resumption, interruption, misuse.
#include "graze_program.hpp"

#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/table.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <csignal>
#include <filesystem>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

Outcome run(std::vector<std::string> more, const std::string& id = "newton-elastic") {
  return call("attractors", id, std::move(more));
}

const std::vector<std::string> small_grid = {"--set", "eta=0.744", "--x=-1.9:2.3:22", "--v=-2:2:12"};

std::vector<std::string> with(std::vector<std::string> options, const std::vector<std::string>& more) {
  options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace

TEST_CASE("attractors: a grid of starts gives basins, fractions with errors, a table") {
  const TemporaryFolder folder;
  const Json json = json_of(run(with(small_grid, {"--json", "-", "--csv", folder.file("starts.csv")})));
  CHECK(json["schema"] == "graze.attractors/1");
  CHECK(json["status"] == "done");
  CHECK(json["starts"] == 22 * 12);
  CHECK(json["lost"] == 0);
  // x = -1.9, -1.7, ... 2.1, 2.3: only the last two of each row lie beyond the barrier at 2.
  const Json& basins = json["basins"];
  REQUIRE(basins["x"].size() == 22);
  REQUIRE(basins["v"].size() == 12);
  REQUIRE(basins["attractor"].size() == 12);
  CHECK(basins["x"].front() == -1.9);
  CHECK(basins["x"].back() == 2.3);
  std::vector<int> counts(json["attractors"].size() + 1, 0);
  for (const Json& row : basins["attractor"]) {
    REQUIRE(row.size() == 22);
    CHECK(row[20].is_null());
    CHECK(row[21].is_null());
    for (std::size_t i = 0; i < 20; ++i) {
      REQUIRE(row[i].is_number());
      ++counts.at(row[i].get<std::size_t>());
    }
  }
  CHECK(json["admissible"] == 20 * 12);
  CHECK(counts[0] == 0);
  REQUIRE(json["attractors"].size() == 2);
  double sum = 0.0;
  for (const Json& found : json["attractors"]) {
    const std::size_t id = found["id"];
    const double f = found["fraction"], N = 20 * 12;
    CHECK(found["count"] == counts.at(id));
    CHECK(f == counts[id] / N);
    CHECK(found["fraction_error"].get<double>() == Approx(std::sqrt(f * (1.0 - f) / N)));
    CHECK(found["states"].size() == found["period"].get<std::size_t>());
    CHECK(found["multipliers"].size() == 2);
    // Newton with k_r = 1: the exponents sum to -2 b.
    CHECK(found["exponents"][0].get<double>() + found["exponents"][1].get<double>() == Approx(-0.1).epsilon(1e-9));
    sum += f;
  }
  CHECK(sum == Approx(1.0).epsilon(1e-14));
  const Table table = parse_csv(read_file(folder.file("starts.csv")), "starts.csv");
  REQUIRE(table.rows.size() == 22 * 12);
  CHECK(table.columns == std::vector<std::string>{"x", "v", "attractor", "type", "period", "impacts"});
  CHECK(table.rows[21][3] == "beyond the barrier");
  CHECK(table.rows[0][2] == basins["attractor"][0][0].dump());
}

TEST_CASE("attractors: the text names each attractor with its share") {
  const Outcome outcome = run(small_grid);
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("z = 2/3") && Contains("z = 4/4") && Contains("of 240 admissible starts"));
}

TEST_CASE("attractors: random starts follow from the seed and lie within the ranges") {
  const std::vector<std::string> options = {"--set", "eta=0.746", "--random", "60", "--x=-1:0", "--v=0.5:1", "--json", "-"};
  const Json json = json_of(run(options));
  REQUIRE(json["basins"]["starts"].size() == 60);
  REQUIRE(json["basins"]["attractor"].size() == 60);
  for (const Json& start : json["basins"]["starts"]) {
    CHECK(start[0].get<double>() >= -1.0);
    CHECK(start[0].get<double>() < 0.0);
    CHECK(start[1].get<double>() >= 0.5);
    CHECK(start[1].get<double>() < 1.0);
  }
  CHECK(json_of(run(options))["basins"] == json["basins"]);
  CHECK(json_of(run(with(options, {"--seed", "2"})))["basins"]["starts"] != json["basins"]["starts"]);
  CHECK_FALSE(picture_of(json).cells);
  CHECK_FALSE(gnuplot_script(picture_of(json), "svg").empty());
}

TEST_CASE("attractors: the default window of a grid ends at the barrier") {
  const Json json = json_of(run({"--set", "eta=0.744", "--v=0:1:2", "--json", "-"}));
  CHECK(json["basins"]["x"].size() == 64);
  CHECK(json["basins"]["x"].back().get<double>() < 2.0);
  // As wide as the motion without barrier, whose amplitude is below 1 / (1 - eta^2); no start lies on the edge of the window.
  CHECK(json["basins"]["x"].front().get<double>() > -std::max(2.0, 1.0 / (1.0 - 0.744 * 0.744)));
  const Json rows = json_of(run({"--set", "eta=0.744", "--x=0:1:2", "--json", "-"}))["basins"];
  CHECK(rows["v"].size() == 64);
  CHECK(rows["v"].front().get<double>() == Approx(-rows["v"].back().get<double>()));
  CHECK(json["admissible"] == 128);
}

TEST_CASE("attractors: the default box contains the attractors") {
  // Fixed: the box ended at the barrier, even for a soft stop.
  for (const char* r : {"r=2", "r=0.2"}) {
    const Json json = json_of(call("attractors", "hertz-damped", {"--set", "eta=0.711", "--set", r, "--json", "-"}));
    const Json &x = json["options"]["x"], &v = json["options"]["v"];
    const auto half = [](const Json& axis) { return 0.5 * (axis[1].get<double>() - axis[0].get<double>()) / 63.0; };
    REQUIRE_FALSE(json["attractors"].empty());
    for (const Json& found : json["attractors"])
      for (const Json& state : found["states"]) {
        CHECK(std::abs(state[0].get<double>() - 0.5 * (x[0].get<double>() + x[1].get<double>())) <= 32.0 * 2.0 * half(x));
        CHECK(std::abs(state[1].get<double>() - 0.5 * (v[0].get<double>() + v[1].get<double>())) <= 32.0 * 2.0 * half(v));
      }
  }
}

TEST_CASE("attractors: the picture has a cell per start, a legend with the shares, and the barrier") {
  const Json json = json_of(run(with(small_grid, {"--json", "-"})));
  const Picture picture = picture_of(json);
  REQUIRE(picture.cells);
  CHECK(picture.cells->colour.size() == 22 * 12);
  CHECK(std::count(picture.cells->colour.begin(), picture.cells->colour.end(), -1) == 24);  // beyond the barrier
  CHECK(std::count(picture.cells->colour.begin(), picture.cells->colour.end(), 0) == json["attractors"][0]["count"].get<int>());
  REQUIRE(picture.curves.size() == 6);  // for each: the states, their dark outline, and the legend entry
  CHECK(picture.curves[1].points.size() == 3);
  CHECK_THAT(picture.curves[2].title, Contains("z = 2/3: ") && Contains(" ± "));
  REQUIRE(picture.barriers.size() == 1);
  CHECK(picture.barriers[0].position == 2.0);
  CHECK_THAT(picture.x_label, Contains("forcing phase 0 (dimensionless)"));
  const std::string script = gnuplot_script(picture, "png");
  CHECK_THAT(script, Contains("with rgbalpha notitle"));
  const TemporaryFolder folder;
  for (const std::string ending : {"png", "svg", "pdf"}) CHECK(draw(picture, ending).size() > 2000);
}

TEST_CASE("attractors continues an interrupted run with identical bits") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  const std::vector<std::string> options = {"--set",     "eta=0.711", "--x=-2:1.9:9", "--v=-2:2:9",
                                            "--periods", "3000",      "--threads",    "2"};
  Json whole = json_of(run(with(options, {"--out", out, "--json", "-"}), "hertz-damped"));
  CHECK(std::filesystem::exists(out + "/attractors.csv"));
  CHECK(std::filesystem::exists(out + "/attractors-basins.png"));
  REQUIRE(whole["attractors"].size() >= 1);
  // The result of an interrupted run: every second start is missing.
  Json part = whole;
  part["status"] = "interrupted";
  for (std::size_t j = 0; j < 9; ++j)
    for (std::size_t i = j % 2; i < 9; i += 2) part["basins"]["attractor"][j][i] = -1;
  folder.write("run/attractors.json", part.dump());
  Json resumed = json_of(run(with(options, {"--resume", out, "--json", "-"}), "hertz-damped"));
  for (const char* key : {"attractors", "basins", "admissible", "lost", "status"}) CHECK(resumed[key] == whole[key]);
  // The file there has the complete result.
  CHECK(Json::parse(read_file(out + "/attractors.json"))["basins"] == whole["basins"]);
  const Outcome other = run(with(options, {"--resume", out, "--set", "b=0.06"}), "hertz-damped");
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("is of another run: parameters.b is 0.05 there and 0.06 now"));
  Json damaged = whole;
  damaged["basins"]["attractor"].erase(0);
  folder.write("run/attractors.json", damaged.dump());
  const Outcome refused = run(with(options, {"--resume", out}), "hertz-damped");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Contains("is damaged; compute it anew"));
}

TEST_CASE("attractors: a signal ends the command and its results are kept") {
  const TemporaryFolder folder;
  const std::string file = folder.file("part.json");
  const Outcome outcome = interrupt("attractors '" + problem("hertz-damped") +
                                        "' --set eta=0.711 --x=-2:1.9:900 --v=-2:2:900 --threads 1 --json '" + file + "'",
                                    "carrying on", SIGINT);
  CHECK(outcome.code == 130);
  CHECK_THAT(outcome.err, Contains("interrupted after ") && Contains(" of 810000 starts"));
  const Json json = Json::parse(read_file(file));
  CHECK(json["status"] == "interrupted");
  CHECK(json["basins"]["attractor"].size() == 900);
}

TEST_CASE("attractors refuses invalid options") {
  const auto misuse = [](std::vector<std::string> more) {
    const Outcome outcome = run(std::move(more));
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    return outcome.err;
  };
  CHECK_THAT(misuse({"--x=-2"}), Contains("--x -2: must be A:B:N"));
  CHECK_THAT(misuse({"--x=-2:a:5"}), Contains("must be A:B:N, N values from A to B"));
  CHECK_THAT(misuse({"--v=1:-1:5"}), Contains("--v 1:-1:5: A:B:N needs A < B; A is 1, B is -1"));
  CHECK_THAT(misuse({"--v=-1:1:0"}), Contains("the number of values must be a whole number >= 1"));
  CHECK_THAT(misuse({"--x=-1:inf:5"}), Contains("must be A:B:N"));
  CHECK_THAT(misuse({"--random", "5", "--x=-1:1:5"}), Contains("must be A:B, a range"));
  CHECK_THAT(misuse({"--random", "0"}), Contains("--random 0") && Contains("whole number >= 1"));
  CHECK_THAT(misuse({"--seed", "3"}), Contains("give --random N too"));
  CHECK_THAT(misuse({"--x=-2:2:2000", "--v=-2:2:2000"}), Contains("more than a million"));
  CHECK_THAT(misuse({"--transient", "0"}), Contains("--transient 0") && Contains("whole number >= 1"));
  CHECK_THAT(misuse({"--x=3:4:3", "--v=0:1:3"}), Contains("all lie beyond the barrier, r = ") && Contains("give --x"));
}
