// SPDX-License-Identifier: GPL-3.0-or-later
// graze reproduce: rows, files, resumption of an interrupted run, misuse.
#include "graze_program.hpp"

#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/published/reproduction.hpp>
#include <graze/apps/text/json.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>

using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

constexpr const char* few = R"([[system]]
id = "newton-elastic"
contact = "newton"
parameters = { b = 0.05, r = 2.0, k_r = 1.0, xi = 1.0, beta = 0.0 }

[[exponents]]
system = "newton-elastic"
eta = 0.746
attractor = "periodic"
z = [2, 2]
initial = [-0.237, -0.887]
lambda = [-0.005, -0.095]
digits = 3
figure = "14b"

[[exponents]]
system = "newton-elastic"
eta = 0.711
attractor = "chaotic"
lambda = [0.030, -0.130]
digits = 3
figure = "11b"

[[diagram]]
system = "newton-elastic"
figure = "10"
eta = [0.736, 0.746]
step = 0.002
windows = [
  { eta = [0.740, 0.746], direction = "both", attractor = "periodic", z = [2, 3] },
  { eta = [0.746, 0.746], direction = "down", attractor = "impactless" },
]
)";

}  // namespace

TEST_CASE("reproduce compares, draws, and continues an interrupted run") {
  const TemporaryFolder folder;
  const std::string file = folder.write("few.toml", few), out = folder.file("out");
  const Outcome whole = call({"reproduce", file, "--no-claims", "--out", out, "--quiet", "--json", "-"});
  INFO(whole.err);
  REQUIRE(whole.code == 0);
  const Json json = Json::parse(whole.out);
  CHECK(json["schema"] == "graze.reproduce/1");
  CHECK(json["status"] == "done");
  REQUIRE(json["rows"].size() == 4);
  for (const Json& row : json["rows"])
    for (const char* key : {"figure", "system", "eta", "quantity", "published", "computed", "uncertainty", "verdict", "remark"})
      CHECK(row.contains(key));
  CHECK(json["rows"][0]["verdict"] == "agrees");
  CHECK(json["rows"][3]["verdict"] == "differs");
  for (const char* name : {"figure-10.png", "figure-11b.png", "figure-14b.png", "index.html", "reproduce.json", "reproduce.csv"})
    CHECK(std::filesystem::exists(out + "/" + name));
  const std::string page = read_file(out + "/index.html");
  CHECK_THAT(page, Contains("<img src=\"figure-14b.png\"") && Contains("z = 2/2"));
  // The result of an interrupted run: half a sweep, one row.
  Json part = json;
  part["status"] = "interrupted";
  part["rows"].erase(part["rows"].begin() + 1, part["rows"].end());
  part["diagrams"][0]["rows"].erase(part["diagrams"][0]["rows"].begin() + 4, part["diagrams"][0]["rows"].end());
  folder.write("out/reproduce.json", part.dump());
  const Outcome resumed = call({"reproduce", file, "--no-claims", "--resume", out, "--quiet", "--json", "-"});
  CHECK(resumed.code == 0);
  CHECK(Json::parse(resumed.out)["rows"] == json["rows"]);
}

TEST_CASE("reproduce keeps the results of an interrupted run") {
  const TemporaryFolder folder;
  const std::string file = folder.write("few.toml", few);
  set_interrupted(true);
  const Outcome outcome = call({"reproduce", file, "--out", folder.file("out"), "--quiet"});
  set_interrupted(false);
  CHECK(outcome.code == 130);
  CHECK_THAT(outcome.err, Contains("interrupted with 0 of 4 rows"));
  CHECK(Json::parse(read_file(folder.file("out/reproduce.json")))["status"] == "interrupted");
}

TEST_CASE("the rows of an interrupted reproduce are those of the complete run") {
  // Fixed: unfinished rows were stored as they were, and --resume took them for finished.
  const TemporaryFolder folder;
  const Published published = load_published(folder.write("few.toml", few));
  int cancel_checks = 0;
  ReproductionOptions options;
  options.claims = false;
  options.cancelled = [&cancel_checks] { return ++cancel_checks == 0; };  // never
  const Reproduction whole = reproduce(published, options);
  REQUIRE(whole.complete);
  const int all = cancel_checks;
  std::size_t most = 0;
  for (int part = 1; part <= 12; ++part) {
    cancel_checks = 0;
    options.cancelled = [&cancel_checks, last = all * part / 13] { return ++cancel_checks > last; };
    const Reproduction found = reproduce(published, options);
    CHECK_FALSE(found.complete);
    most = std::max(most, found.rows.size());
    for (const Comparison& row : found.rows)
      CHECK(std::any_of(whole.rows.begin(), whole.rows.end(), [&](const Comparison& other) {
        return row.quantity == other.quantity && row.published == other.published && row.computed == other.computed &&
               row.remark == other.remark && row.details == other.details;
      }));
  }
  CHECK(most > 0);
}

TEST_CASE("reproduce refuses invalid input") {
  const TemporaryFolder folder;
  CHECK(call({"reproduce", folder.file("none.toml")}).code == 2);
  CHECK_THAT(call({"reproduce", folder.file("none.toml")}).err, Contains("no such file"));
  const std::string file = folder.write("few.toml", few);
  CHECK_THAT(call({"reproduce", file, "--resume", folder.file("nowhere")}).err, Contains("--resume"));
  CHECK_FALSE(std::filesystem::exists(folder.file("nowhere")));
  CHECK_THAT(call({"reproduce", file, "--json", file}).err, Contains("--json"));
}
