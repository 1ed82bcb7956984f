// SPDX-License-Identifier: GPL-3.0-or-later
// Results of every command for a mass at rest on a preloaded stop, and for a system without dissipation. Also: an orbit on
// which the motion did not settle.
#include "graze_program.hpp"

#include <graze/apps/text/json.hpp>

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

std::vector<std::string> pressed(const std::string& k_r, std::vector<std::string> more) {
  std::vector<std::string> all = {"--set",   "xi=0.7", "--set",  "r=-1",  "--set",
                                  "eta=0.8", "--set",  "b=0.02", "--set", "k_r=" + k_r};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

Json result(const std::string& command, std::vector<std::string> more) {
  more.insert(more.end(), {"--json", "-"});
  return json_of(call(command, "newton-elastic", more));
}

/// Null in JSON (minus infinity), or the exponent for elastic impacts.
void check_exponent(const Json& exponent, const std::string& k_r) {
  if (k_r == "1")
    CHECK(exponent.get<double>() == Approx(-0.04 / 3.0).epsilon(1e-9));
  else
    CHECK(exponent.is_null());
}

}  // namespace

TEST_CASE("all commands agree on a mass at rest on a preloaded stop") {
  for (const std::string k_r : {"0", "0.8", "1"}) {
    INFO("k_r " << k_r);
    const Json orbit = result("orbit", pressed(k_r, {}))["orbit"];
    CHECK(orbit["rests"] == true);
    CHECK(orbit["stable"] == true);
    check_exponent(orbit["exponents"][0], k_r);
    const Json lyapunov = result("lyapunov", pressed(k_r, {}));
    CHECK(lyapunov["attractor"]["rests"] == true);
    check_exponent(lyapunov["exponents"][0], k_r);
    check_exponent(lyapunov["time_average"]["exponents"][0], k_r);
    const Json sweep = result("sweep", pressed(k_r, {"--from", "0.8", "--to", "0.82", "--step", "0.01"}));
    REQUIRE(sweep["rows"].size() == 3);
    for (const Json& row : sweep["rows"]) {
      CHECK(row["attractor"]["rests"] == true);
      check_exponent(row["exponents"][0], k_r);
    }
    const Json map = result("map", pressed(k_r, {"--param", "eta:0.8:0.82:2", "--param", "xi:0.6:0.7:2"}))["layers"][0];
    for (int i = 0; i < 4; ++i) {
      CHECK(map["type"][i / 2][i % 2] == "periodic");
      check_exponent(map["lambda_1"][i / 2][i % 2], k_r);
    }
    const Json attractors = result("attractors", pressed(k_r, {"--x=-2:-1:4", "--v=-0.5:0.5:4"}));
    REQUIRE(attractors["attractors"].size() == 1);
    CHECK(attractors["attractors"][0]["rests"] == true);
  }
}

TEST_CASE("a sweep over the clearance starts in front of the barrier and a mass at rest moves with its stop") {
  const Json sweep = result("sweep", {"--set", "xi=0.7", "--set", "eta=0.8", "--set", "k_r=0.8", "--param", "r", "--from", "-1.2",
                                      "--to", "-1", "--step", "0.1", "--direction", "both"});
  REQUIRE(sweep["rows"].size() == 6);
  for (const Json& row : sweep["rows"]) CHECK(row["attractor"]["rests"] == true);
}

TEST_CASE("lyapunov without dissipation claims no attractor") {
  const Json json = result("lyapunov", {"--set", "b=0", "--set", "eta=2.8", "--set", "r=-0.1", "--start=-0.68771149,0.365807336",
                                        "--settle", "100", "--periods", "40000"});
  CHECK(json["attractor"]["type"] == "undecided");
  CHECK(json["attractor"]["conservative"] == true);
  CHECK(json["attractor"]["motion"] == "island");
}

TEST_CASE("orbit reports in its result that the motion settled on another orbit than the one returned") {
  const Outcome outcome = call("orbit", "newton-elastic", {"--set", "eta=0.9"});
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("z = 1/2, stable"));
  CHECK_THAT(outcome.out, Contains("the motion does not settle on the orbit above"));
  const Json json = result("orbit", {"--set", "eta=0.9"});
  CHECK(json["orbit"]["period"] == 1);
  CHECK(json["orbit"]["stable"] == false);
  CHECK(json["settled"]["orbit"]["period"] == 2);
  CHECK(json["settled"]["orbit"]["stable"] == true);
  CHECK(json["settled"]["orbit"]["is_result"] == false);
}
