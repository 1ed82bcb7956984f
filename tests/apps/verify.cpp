// SPDX-License-Identifier: GPL-3.0-or-later
// graze verify: ranges, the largest disagreements, the hard limit, exit codes, misuse.
#include "graze_program.hpp"

#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/table.hpp>

#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

Outcome run(std::vector<std::string> more, const std::string& id = "hertz-damped") { return call("verify", id, std::move(more)); }

}  // namespace

TEST_CASE("verify covers a range and reports the largest disagreements") {
  const TemporaryFolder folder;
  const Outcome outcome = run({"--from", "0.95", "--to", "0.92", "--step", "0.01", "--average", "200", "--settle", "300", "--csv",
                               folder.file("t.csv"), "--json", folder.file("t.json")});
  INFO(outcome.err);
  CHECK(outcome.code == 0);
  const Json json = Json::parse(read_file(folder.file("t.json")));
  CHECK(json["agrees"] == true);
  CHECK(json["parameter"] == "eta");
  REQUIRE(json["orbits"].size() == 4);
  std::size_t checks = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Json& orbit = json["orbits"][k];
    CHECK(orbit["value"].get<double>() == Approx(0.95 - 0.01 * static_cast<double>(k)));
    CHECK(orbit["impacts"] == 1);
    CHECK(orbit["exponents"]["periods"] == 200);
    for (std::size_t i = 0; i < 2; ++i)
      CHECK(orbit["exponents"]["time_average"][i].get<double>() ==
            Approx(orbit["exponents"]["multipliers"][i].get<double>()).margin(3e-3));
    checks += orbit["checks"].size();
  }
  CHECK(parse_csv(read_file(folder.file("t.csv")), "t.csv").rows.size() == checks);
  REQUIRE(json["largest"].size() == 9);
  for (const Json& worst : json["largest"]) {
    INFO(worst["name"]);
    CHECK(worst["ok"] == true);
    double ratio = 0.0;
    for (const Json& orbit : json["orbits"])
      for (const Json& check : orbit["checks"])
        if (check["name"] == worst["name"])
          ratio = std::max(ratio, check["disagreement"].get<double>() / check["bound"].get<double>());
    CHECK(worst["disagreement"].get<double>() / worst["bound"].get<double>() == ratio);
    const Json& orbit = json["orbits"][worst["orbit"].get<std::size_t>() - 1];
    CHECK(orbit["value"] == worst["value"]);
  }
  // One row per orbit, one of the largest.
  for (const char* text : {"0.95  ", "0.92  ", "largest", "mu GSL", "verdict"}) CHECK_THAT(outcome.out, Contains(text));
  const Picture picture = picture_of(json);
  CHECK(picture.curves.size() == 9);
  CHECK(picture.curves[0].points.size() == 4);
  CHECK(picture.x_label == "eta (dimensionless)");
}

TEST_CASE("verify finds all orbits at each value with --search") {
  const Outcome outcome =
      run({"--from", "0.9", "--to", "0.91", "--step", "0.01", "--period", "2", "--search", "--average", "0", "--json", "-"},
          "newton-elastic");
  const Json json = Json::parse(outcome.out);
  INFO(outcome.err);
  CHECK(outcome.code == 0);
  int at[2] = {0, 0};
  for (const Json& orbit : json["orbits"]) ++at[orbit["value"] == 0.9 ? 0 : 1];
  CHECK(at[0] >= 1);
  CHECK(at[1] >= 1);
  for (const Json& worst : json["largest"]) {
    INFO(worst.dump());
    CHECK((worst["name"] != "exponents" || worst["disagreement"].is_null()));  // --average 0 compares none
  }
}

TEST_CASE("verify compares soft contacts with the rigid stop") {
  const TemporaryFolder folder;
  const Outcome outcome = run({"--hard-limit", "--average", "0", "--out", folder.file("run")});
  INFO(outcome.err);
  CHECK(outcome.code == 0);
  const Json json = Json::parse(read_file(folder.file("run/verify.json")));
  const Json& hard = json["orbits"][0]["hard_limit"];
  CHECK(hard["steps"].size() == 7);
  CHECK(hard["steps"][0]["k_H"].get<double>() == Approx(1e3));
  // 2/5 in the limit: at the largest k_H the contribution of the next order is below 1e-3.
  CHECK(hard["steps"][6]["order"].get<double>() == Approx(0.4).margin(1e-3));
  CHECK(hard["restitution"].size() == 48);
  for (const char* kind : {"checks", "restitution", "hard-limit"})
    CHECK(std::filesystem::exists(folder.file(std::string("run/verify-") + kind + ".png")));
  CHECK(json["orbits"][0]["checks"].size() == 9 + 5);
  CHECK_THAT(outcome.out, Contains("closed form"));
  // Without damping there is no restitution to show, and nothing is missing.
  const Outcome undamped = run({"--hard-limit", "--average", "0", "--out", folder.file("undamped")}, "hertz-undamped");
  CHECK(undamped.code == 0);
  CHECK_FALSE(std::filesystem::exists(folder.file("undamped/verify-restitution.png")));
  CHECK(std::filesystem::exists(folder.file("undamped/verify-hard-limit.png")));
}

TEST_CASE("verify ends with 1 if a result is missing and names it") {
  // This orbit ends at a grazing before the contact is stiff.
  const Outcome lost = run({"--set", "eta=0.8247", "--period", "2", "--hard-limit", "--average", "0", "--json", "-"});
  CHECK(lost.code == 1);
  CHECK_THAT(lost.err, Contains("hard limit: the orbit could not be followed"));
  CHECK(Json::parse(lost.out)["agrees"] == false);
  CHECK(Json::parse(lost.out)["orbits"].size() == 1);
  // There is no orbit of period 3 here.
  const Outcome none =
      run({"--from", "0.95", "--to", "0.94", "--step", "0.01", "--period", "3", "--settle", "200", "--json", "-"});
  CHECK(none.code == 1);
  CHECK_THAT(none.err, Contains("at eta = 0.95: no admissible orbit of period 3"));
  CHECK_THAT(none.err, Contains("at eta = 0.94: no admissible orbit of period 3"));
  CHECK(Json::parse(none.out)["orbits"].empty());
}

TEST_CASE("verify refuses invalid options") {
  const auto misuse = [](std::vector<std::string> more, const std::string& id = "hertz-damped") {
    const Outcome outcome = run(std::move(more), id);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    return outcome.err;
  };
  CHECK_THAT(misuse({"--to", "0.9"}), Contains("a range needs both --to and --step; --step is missing"));
  CHECK_THAT(misuse({"--step", "0.1"}), Contains("--to is missing"));
  CHECK_THAT(misuse({"--to", "0.9", "--step", "0"}), Contains("--step is 0; allowed is > 0"));
  CHECK_THAT(misuse({"--from", "0.9", "--to", "0.9", "--step", "0.1"}), Contains("its ends must differ"));
  CHECK_THAT(misuse({"--to", "-0.05", "--step", "0.1"}), Contains("--from, --to"));
  CHECK_THAT(misuse({"--param", "eat", "--from", "0.9"}), Contains("eta"));
  CHECK_THAT(misuse({"--plot-kind", "restitution", "--plot", "x.png"}), Contains("add --hard-limit"));
  CHECK_THAT(misuse({"--hard-limit"}, "beam-linear"), Contains("the contact law here is linear"));
  CHECK_THAT(misuse({"--hard-limit", "--set", "k_r=0.8"}, "newton-elastic"), Contains("here k_r is 0.8"));
  CHECK_THAT(misuse({"--hard-limit", "--param", "k_r", "--from", "1"}, "newton-elastic"), Contains("k_r is varied"));
}
