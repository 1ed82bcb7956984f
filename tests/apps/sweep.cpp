// SPDX-License-Identifier: GPL-3.0-or-later
// graze sweep: rows with attractors and exponents, hysteresis, resumption of an interrupted run, misuse.
#include "graze_program.hpp"

#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/json.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

Outcome run(std::vector<std::string> more, const std::string& id = "newton-elastic") {
  return call("sweep", id, std::move(more));
}

}  // namespace

TEST_CASE("sweep follows the attractor and shows hysteresis") {
  // Upwards the impactless orbit lasts to its grazing at 0.7107; downwards chaos lasts to 0.6975.
  const Json json = json_of(run(
      {"--from", "0.69", "--to", "0.715", "--step", "0.001", "--direction", "both", "--standard-error", "5e-4", "--json", "-"},
      "hertz-damped"));
  CHECK(json["schema"] == "graze.sweep/1");
  REQUIRE(json["rows"].size() == 26 * 2);
  for (const Json& row : json["rows"]) {
    const double eta = row["value"];
    INFO(row["direction"] << " " << eta);
    if (row["direction"] == "up" && eta < 0.7106) {
      CHECK(row["attractor"]["type"] == "periodic");
      CHECK(row["attractor"]["impacts"] == 0);
      CHECK(row["exponents"][0].get<double>() == Approx(-0.05).epsilon(1e-12));
      CHECK(row["states"].size() == 1);
      CHECK(row["impact_speeds"].empty());
    }
    if (row["direction"] == "down" && eta > 0.6985 && eta < 0.7145) {
      CHECK(row["attractor"]["type"] == "chaotic");
      CHECK_FALSE(row["impact_speeds"].empty());
    }
  }
}

TEST_CASE("sweep: an attractor that sticks is one for any count of the impacts of its chatter") {
  const Outcome outcome = run({"--set", "k_r=0.5", "--set", "r=0", "--from", "0.3", "--to", "0.4", "--step", "0.02"});
  REQUIRE(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("z = ∞/1         6              -infinity  -infinity"));
  const Json json =
      json_of(run({"--set", "k_r=0.5", "--set", "r=0", "--from", "0.3", "--to", "0.4", "--step", "0.02", "--json", "-"}));
  const Picture exponents = picture_of(json, "exponents");
  const auto marks = std::find_if(exponents.curves.begin(), exponents.curves.end(),
                                  [](const Curve& curve) { return curve.title == "exponent 1 is -infinity"; });
  REQUIRE(marks != exponents.curves.end());
  CHECK(marks->points.size() == 6);
}

TEST_CASE("sweep: in its picture down is wider and below up and the legend has visible dots") {
  const Json json = json_of(run({"--from", "0.9", "--to", "0.91", "--step", "0.005", "--direction", "both", "--json", "-"}));
  const Picture picture = picture_of(json, "states");
  REQUIRE(picture.curves.size() == 4);
  CHECK(picture.curves[0].title == "sweep down");
  CHECK(picture.curves[0].size > 1.0);
  CHECK(picture.curves[1].title == "sweep up");
  CHECK(picture.curves[2].size > picture.curves[3].size);
  CHECK_THAT(gnuplot_script(picture, "svg"), !Contains("e+29"));
}

TEST_CASE("sweep continues an interrupted run with identical bits") {
  const TemporaryFolder folder;
  const std::vector<std::string> options = {"--from", "0.74", "--to", "0.75", "--step", "0.002"};
  const auto with = [&](std::vector<std::string> more, std::vector<std::string> before = {}) {
    before.insert(before.end(), options.begin(), options.end());
    before.insert(before.end(), more.begin(), more.end());
    return before;
  };
  const std::string out = folder.file("run");
  const Json whole = json_of(run(with({"--out", out, "--json", "-"})));
  REQUIRE(whole["rows"].size() == 6);
  CHECK(std::filesystem::exists(out + "/sweep-diagram.png"));
  CHECK(std::filesystem::exists(out + "/sweep-states.png"));
  CHECK(std::filesystem::exists(out + "/sweep-exponents.png"));
  Json part = whole;
  part["status"] = "interrupted";
  part["rows"].erase(part["rows"].begin() + 3, part["rows"].end());
  folder.write("run/sweep.json", part.dump());
  for (const char* unfinished : {".sweep.csv.a1B2c3", ".sweep-states.png.XXXXXX"})  // it was killed during the writing
    folder.write(std::string("run/") + unfinished, "half");
  folder.write("run/.sweep.backup", "mine");
  const Json resumed = json_of(run(with({"--resume", out, "--json", "-"})));
  CHECK_FALSE(std::filesystem::exists(folder.file("run/.sweep.csv.a1B2c3")));
  CHECK_FALSE(std::filesystem::exists(folder.file("run/.sweep-states.png.XXXXXX")));
  CHECK(std::filesystem::exists(folder.file("run/.sweep.backup")));
  CHECK(resumed["rows"].size() == 6);
  CHECK(resumed == whole);  // stored rows are written again unchanged, multipliers included
  const Outcome other = run(with({"--resume", out, "--set", "b=0.06"}));
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("sweep.json is of another run: parameters.b is 0.05 there and 0.06 now; give the same"));
  const Outcome shorter = run(with({"--resume", out, "--periods", "400"}));
  CHECK(shorter.code == 2);
  CHECK_THAT(shorter.err, Contains("options.periods is 20000 there and 400 now"));
  std::filesystem::copy_file(problem("newton-elastic"), folder.file("same.toml"));
  const Outcome renamed = call(with({"--resume", out, "--json", "-", "--quiet"}, {"sweep", folder.file("same.toml")}));
  CHECK(json_of(renamed)["rows"] == whole["rows"]);
  folder.write("run/sweep.json", "{\n\"schema\": [1,");
  CHECK_THAT(run(with({"--resume", out})).err,
             Contains("run/sweep.json: invalid JSON: the file ends early, in line 2; compute it anew"));
}

TEST_CASE("sweep does not depend on the number of threads for cancelled rows too") {
  // At 0.71 transient chaos may look like chaos until its average ends, depending on rounding. Rows that other threads have
  // computed from it meanwhile are discarded.
  const std::vector<std::string> range = {"--from", "0.65",        "--to", "0.72",   "--step",
                                          "0.002",  "--direction", "both", "--json", "-"};
  const auto rows = [&](const char* threads) {
    std::vector<std::string> options = range;
    options.insert(options.end(), {"--threads", threads});
    return json_of(run(options))["rows"];
  };
  const Json one = rows("1"), several = rows("4");
  CHECK(one == several);
}

TEST_CASE("sweep refuses invalid options") {
  const auto misuse = [](std::vector<std::string> more) {
    const Outcome outcome = run(std::move(more));
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    return outcome.err;
  };
  CHECK_THAT(misuse({"--from", "0.8", "--to", "0.7", "--step", "0.01"}),
             Contains("--from 0.8 and --to 0.7: the range is empty; --from must be below --to"));
  CHECK_THAT(misuse({"--from", "0.7", "--to", "0.8", "--step", "0"}), Contains("--step is 0; allowed is > 0"));
  CHECK_THAT(misuse({"--from", "0.7", "--to", "0.8", "--step", "1e-9"}), Contains("at most a million"));
  CHECK_THAT(misuse({"--from", "0", "--to", "0.8", "--step", "0.1"}), Contains("--from"));
  CHECK_THAT(misuse({"--from", "0.7", "--to", "0.8", "--step", "0.1", "--direction", "sideways"}), Contains("sideways"));
  const std::vector<std::string> r = {"--param", "r", "--from", "0", "--to", "3", "--step", "0.5", "--start", "1.5,0"};
  CHECK_THAT(misuse(r),
             Contains("--start 1.5,0: the state (1.5, 0) lies inside the barrier; give one on its free side, x <= r = 0"));
}
