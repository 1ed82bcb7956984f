// SPDX-License-Identifier: GPL-3.0-or-later
// graze locate: the nearest point within the reach, from any orbit that leads to it, with a message if it is far from the
// requested value.
#include "graze_program.hpp"

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

Outcome locate_elastic(std::vector<std::string> more) {
  more.insert(more.end(), {"--set", "b=0.02", "--set", "r=1", "--set", "k_r=0.9", "--json", "-"});
  return call("locate", "newton-elastic", std::move(more));
}

}  // namespace

TEST_CASE("locate gives the nearest fold and not that of another branch") {
  // Fixed: orbits were searched at --near alone, and the first one with such a point was used: 0.358887.
  const Json json =
      json_of(locate_elastic({"--set", "eta=0.799", "--type", "LP", "--param", "xi", "--near", "0.362836", "--period", "2"}));
  CHECK(std::abs(json["special_point"]["value"].get<double>() - 0.362836201981) < 1e-11);
  CHECK(json["special_point"]["impacts"] == 1);
}

TEST_CASE("locate finds a grazing on a branch that does not extend to the requested value") {
  // Without impact the amplitude is 1 / sqrt((1 - eta^2)^2 + 4 b^2 eta^2) = r = 1 at eta^2 = 2 - 4 b^2. Fixed: from below,
  // where another orbit is found, this grazing was missed.
  const double grazing = std::sqrt(2.0 - 4.0 * 0.02 * 0.02);
  for (const char* near : {"1.35", "1.41", "1.414"}) {
    const Json json = json_of(locate_elastic({"--type", "GR", "--near", near}));
    CHECK(std::abs(json["special_point"]["value"].get<double>() - grazing) < 1e-12);
    CHECK(json.contains("message") == (std::string(near) == "1.35"));
  }
}

TEST_CASE("locate reports a point far from the requested value") {
  const Json far = json_of(locate_elastic({"--type", "GR", "--near", "1.45"}));
  CHECK_THAT(far["message"].get<std::string>(),
             Contains("the nearest GR lies 0.0364 from --near 1.45, farther than a tenth of the"));
  CHECK(far["status"] == "done");
  const Json digits = json_of(locate_elastic({"--type", "GR", "--near", "1.41001"}));
  CHECK_THAT(digits["message"].get<std::string>(), Contains("from --near 1.41001, farther than its digits suggest"));
  const Outcome text = call("locate", "newton-elastic", {"--type", "GR", "--near", "0.70001"});
  CHECK(text.code == 0);
  CHECK_THAT(text.out, Contains("eta = 0.710687369094") && Contains("farther than"));
  CHECK_FALSE(json_of(call("locate", "hertz-damped", {"--type", "PD", "--near", "0.92", "--json", "-"})).contains("message"));
}

TEST_CASE("locate searches at --from alone if it is given") {
  CHECK(locate_elastic({"--type", "GR", "--near", "1.41", "--from", "1.4", "--reach", "0.02"}).code == 1);
  CHECK(locate_elastic({"--type", "GR", "--near", "1.41", "--from", "1.42", "--reach", "0.02"}).code == 0);
}
