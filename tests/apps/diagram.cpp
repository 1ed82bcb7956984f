// SPDX-License-Identifier: GPL-3.0-or-later
// graze diagram --skeleton: misuse, the contents of its JSON, its picture, independence of the number of threads, Ctrl-C.
// Complete diagrams are tested in whole_diagram.cpp.
#include "graze_program.hpp"

#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/json.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <numeric>
#include <set>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

/// A run over a small range, in which the 2/2 orbit is doubled (eta = 0.745136301).
Outcome small(std::vector<std::string> more) {
  std::vector<std::string> arguments = {"diagram", problem("newton-elastic"), "--skeleton", "--from", "0.743", "--to", "0.747",
                                        "--quiet"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return call(arguments);
}

std::string misuse(std::vector<std::string> more) {
  more.insert(more.begin(), {"diagram", problem("newton-elastic")});
  const Outcome outcome = call(more);
  CHECK(outcome.code == 2);
  CHECK(outcome.out.empty());
  return outcome.err;
}

}  // namespace

TEST_CASE("diagram refuses invalid options") {
  CHECK_THAT(misuse({"--skeleton", "--from", "0.7", "--to", "0.8", "--step", "0.1"}),
             Contains("--step belongs to the sweeps, and --skeleton has none"));
  CHECK_THAT(misuse({"--skeleton", "--from", "0.7", "--to", "0.8", "--plot-kind", "states"}),
             Contains("--plot-kind states: with --skeleton it is one of branch, multipliers, skeleton"));
  CHECK_THAT(misuse({"--skeleton", "--from", "0.7", "--to", "0.7"}), Contains("--from 0.7 and --to 0.7: the range is empty; they must differ"));
  CHECK_THAT(misuse({"--skeleton", "--from", "0.7"}), Contains("--to is required"));
  CHECK_THAT(misuse({"--skeleton", "--to", "0.7"}), Contains("--from is required"));
  CHECK_THAT(misuse({"--skeleton", "--from", "0", "--to", "0.7"}), Contains("eta is 0; allowed is >= 0.0001"));
  CHECK_THAT(misuse({"--skeleton", "--from", "0.7", "--to", "0.8", "--param", "etta"}), Contains("did you mean \"eta\""));
  CHECK_THAT(misuse({"--skeleton", "--from", "0.7", "--to", "0.8", "--max-step", "0"}),
             Contains("--max-step is 0; allowed is > 0"));
  for (const char* option : {"--max-period", "--max-branches"})
    for (const char* value : {"0", "-2", "2.5", "many"})
      CHECK_THAT(misuse({"--skeleton", "--from", "0.7", "--to", "0.8", std::string(option) + "=" + value}),
                 Contains(std::string(option) + " " + value) && Contains("whole number >= 1"));
}

TEST_CASE("diagram gives seeds, branches and their relations") {
  const TemporaryFolder folder;
  const std::string picture = folder.file("skeleton.svg");
  const Json result = json_of(small({"--max-period", "4", "--threads", "1", "--plot", picture, "--json", "-"}));
  CHECK(result["schema"] == "graze.branch/1");
  CHECK(result["command"] == "diagram");
  CHECK(result["status"] == "done");
  REQUIRE_FALSE(result["seeds"].empty());
  for (const Json& seed : result["seeds"]) {
    CHECK(seed["value"].get<double>() >= 0.743);
    CHECK(seed["value"].get<double>() <= 0.747);
    CHECK(seed["state"].size() == 2);
    CHECK((seed["origin"] == "settled" || seed["origin"] == "searched" || seed["origin"] == "given"));
  }
  std::set<std::pair<int, std::string>> points;
  std::set<int> ids;
  double doubling = 0.0;
  for (const Json& branch : result["branches"]) {
    CHECK(ids.insert(branch["id"].get<int>()).second);
    CHECK(branch["period"].get<int>() <= 4);
    for (const Json& point : branch["special_points"]) {
      CHECK(points.insert({branch["id"].get<int>(), point["label"].get<std::string>()}).second);
      if (point["type"] == "PD" && branch["period"] == 2) doubling = point["value"];
    }
  }
  CHECK(std::abs(doubling - 0.745136301197) < 1e-11);
  int born = 0;
  for (const Json& branch : result["branches"])
    if (!branch["parent"].is_null()) {
      CHECK(points.contains({branch["parent"]["branch"].get<int>(), branch["parent"]["label"].get<std::string>()}));
      ++born;
    }
  CHECK(born >= 1);
  CHECK(result["cascades"].is_array());
  // The picture shows the whole diagram, and is the same when drawn afterwards.
  const std::string drawn = read_file(picture);
  CHECK_THAT(drawn, Contains("</svg>") && Contains("Skeleton of periodic orbits") && Contains("period 4") && Contains("PD1"));
  CHECK(drawn == draw(picture_of(result, "skeleton"), "svg"));
  CHECK(drawn == draw(picture_of(result), "svg"));

  const Outcome two = small({"--max-period", "4", "--threads", "2", "--json", "-"});
  CHECK(two.out == pretty(result));
}

TEST_CASE("diagram lists the families that it did not follow") {
  const Json result = json_of(small({"--max-period", "2", "--json", "-"}));
  REQUIRE(result["cut_off"].size() == 1);
  CHECK_THAT(result["cut_off"][0]["label"].get<std::string>(), Contains("PD"));
  CHECK_THAT(result["cut_off"][0]["reason"].get<std::string>(), Contains("period 4 is above the limit, 2"));

  const Json one = json_of(small({"--max-period", "4", "--max-branches", "1", "--json", "-"}));
  CHECK(one["branches"].size() == 1);
  CHECK_FALSE(one["cut_off"].empty());

  const TemporaryFolder folder;
  const std::string out = folder.file("all");
  CHECK_THAT(small({"--max-period", "2", "--out", out}).out, Contains("not followed (1):"));
  for (const char* name : {"diagram.json", "diagram.csv", "diagram-skeleton.png"})
    CHECK(std::filesystem::file_size(out + "/" + name) > 0);
}

TEST_CASE("diagram reports the fineness of its search and the omitted families which --all keeps") {
  const TemporaryFolder folder;
  const Outcome said = small({"--max-period", "4", "--json", folder.file("some.json")});
  CHECK(said.code == 0);
  CHECK_THAT(said.out,
             Contains("orbits up to period 4 were searched at 121 values of eta, 3.333e-05 apart, as the ends of motions "
                      "from 128 starts each"));
  const Json some = Json::parse(read_file(folder.file("some.json")));
  CHECK(some["options"]["all"] == false);
  CHECK(some["search"]["max_period"] == 4);
  CHECK(some["search"]["values"] == 121);
  CHECK(some["search"]["spacing"].get<double>() == Approx(0.004 / 120));
  CHECK(some["search"]["unstable"]["values"] == 0);
  const Outcome said_of_all = small({"--max-period", "4", "--all", "--json", folder.file("all.json")});
  const Json all = Json::parse(read_file(folder.file("all.json")));
  CHECK(all["options"]["all"] == true);
  CHECK(all["search"]["unstable"]["values"].get<int>() > 0);
  CHECK(all["search"]["unstable"]["max_period"] == 4);
  CHECK(all["branches"].size() > some["branches"].size());
  CHECK_THAT(said.out, Contains("unstable ones were not (--all)"));
  CHECK_THAT(said_of_all.out, Contains("unstable ones up to period 4 at 7 values"));
  // The points of the smaller result are among those of the larger one.
  for (const Json& branch : some["branches"])
    for (const Json& point : branch["special_points"]) {
      if (point["type"] == "EP") continue;
      bool there = false;
      for (const Json& other : all["branches"])
        for (const Json& same : other["special_points"])
          there = there ||
                  (same["type"] == point["type"] && std::abs(same["value"].get<double>() - point["value"].get<double>()) < 1e-12);
      INFO(point["label"] << " at " << point["value"]);
      CHECK(there);
    }
}

TEST_CASE("Ctrl-C ends a diagram with its results so far") {
  const TemporaryFolder folder;
  const Json json = interrupted_json("diagram " + problem("hertz-damped") + " --skeleton --from 0.65 --to 0.95 --threads 1",
                                     folder.file("r.json"), "skeleton");
  CHECK(json["branches"].is_array());
  CHECK(folder.files() == 1);
}

TEST_CASE("diagram continues an interrupted run") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run");
  const Json whole = json_of(small({"--out", out, "--json", "-"}));
  const auto values = [](const Json& result) {
    std::vector<double> list;
    for (const Json& branch : result["branches"])
      for (const Json& point : branch["special_points"])
        if (point["type"] != "EP") list.push_back(point["value"]);
    std::sort(list.begin(), list.end());
    return list;
  };
  // The first branch is complete, the second is cut off, and the others are missing.
  Json part = Json::parse(read_file(out + "/diagram.json"));
  REQUIRE(part["branches"].size() > 2);
  part["status"] = "interrupted";
  part["branches"].erase(part["branches"].begin() + 2, part["branches"].end());
  part["branches"][1]["stop"]["reason"] = "interrupted";
  part["branches"][1]["points"].erase(part["branches"][1]["points"].begin() + 3, part["branches"][1]["points"].end());
  part["branches"][1]["special_points"] = Json::array();
  std::filesystem::create_directory(folder.file("left"));
  folder.write("left/diagram.json", part.dump());
  const Json resumed = json_of(small({"--resume", folder.file("left"), "--json", "-"}));
  CHECK(resumed["status"] == "done");
  CHECK(resumed["branches"].size() == whole["branches"].size());
  const std::vector<double> a = values(whole), b = values(resumed);
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(std::abs(a[i] - b[i]) < 1e-11);  // to the precision of their location
  CHECK(read_file(folder.file("left/diagram.json")).find("\"interrupted\"") == std::string::npos);

  const std::vector<std::string> range = {"--skeleton", "--from", "0.743", "--to", "0.747"};
  const auto refused = [&](std::vector<std::string> more) {
    more.insert(more.begin(), range.begin(), range.end());
    return misuse(more);
  };
  CHECK_THAT(refused({"--resume", folder.file("nowhere")}), Contains("no such file"));
  CHECK_THAT(refused({"--resume", out, "--set", "b=0.06"}), Contains("of another run: parameters.b is 0.05 there and 0.06 now"));
  CHECK_THAT(misuse({"--skeleton", "--from", "0.743", "--to", "0.748", "--resume", out}),
             Contains("over another range: eta from 0.743 to 0.747"));
  folder.write("left/diagram.json", "{\"command\": \"orbit\"}");
  CHECK_THAT(refused({"--resume", folder.file("left")}), Contains("is not a result of graze diagram"));
  Json damaged = part;
  damaged["branches"][0].erase("points");
  folder.write("left/diagram.json", damaged.dump());
  CHECK_THAT(refused({"--resume", folder.file("left")}), Contains("branch 1 of the result is damaged"));
}

TEST_CASE("diagram also continues within its search for seeds and repeats no part of it") {
  // Interrupted before the first step: the parts of the search are listed, and none of them is done.
  set_interrupted(true);
  const Outcome stopped = small({"--json", "-"});
  set_interrupted(false);
  CHECK(stopped.code == 130);
  const Json begun = Json::parse(stopped.out);
  const std::size_t parts = begun["seed_search"]["parts"];
  REQUIRE(parts > 3);
  CHECK(begun["seed_search"]["done"].empty());

  const Json whole = json_of(small({"--json", "-"}));
  CHECK_FALSE(whole.contains("seed_search"));
  CHECK_FALSE(whole["seeds"][0].contains("part"));
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("left"));
  // The result of a run that was interrupted with the parts `done` completed. Here all settled seeds belong to one part, and
  // those of the searches to another.
  const auto resumed = [&](const std::vector<std::size_t>& done, const std::string& dropped = {}) {
    Json part = whole;
    part["status"] = "interrupted";
    part["branches"] = part["cascades"] = part["cut_off"] = part["seeds"] = Json::array();
    part["seed_search"] = {{"parts", parts}, {"done", done}};
    for (Json seed : whole["seeds"]) {
      if (seed["origin"] == dropped) continue;
      if (seed["origin"] != "given") seed["part"] = seed["origin"] == "settled" ? 2 : 3;
      part["seeds"].push_back(seed);
    }
    folder.write("left/diagram.json", part.dump());
    return json_of(small({"--resume", folder.file("left"), "--json", "-"}));
  };
  const auto same_seeds = [&](const Json& result) {
    REQUIRE(result["seeds"].size() == whole["seeds"].size());
    for (std::size_t i = 0; i < whole["seeds"].size(); ++i) {
      const Json &a = result["seeds"][i], &b = whole["seeds"][i];
      for (const char* key : {"value", "period", "impacts", "origin", "stable"}) CHECK(a[key] == b[key]);
      for (std::size_t k = 0; k < 2; ++k) CHECK(a["state"][k].get<double>() == Approx(b["state"][k].get<double>()).margin(1e-11));
    }
    CHECK(result["branches"].size() == whole["branches"].size());
    CHECK_FALSE(result.contains("seed_search"));
  };
  std::vector<std::size_t> all(parts);
  std::iota(all.begin(), all.end(), std::size_t{0});
  same_seeds(resumed(all));
  same_seeds(resumed({0, 1, 2}));
  // A removed seed shows which parts are repeated: it is missing if its part is done, and found again if it is not.
  const auto settled =
      std::count_if(whole["seeds"].begin(), whole["seeds"].end(), [](const Json& seed) { return seed["origin"] == "settled"; });
  REQUIRE(settled > 0);
  const Json without = resumed(all, "settled");
  CHECK(std::none_of(without["seeds"].begin(), without["seeds"].end(),
                     [](const Json& seed) { return seed["origin"] == "settled"; }));
  std::vector<std::size_t> searches(all.begin() + 3, all.end());
  same_seeds(resumed(searches, "settled"));

  Json damaged = whole;
  damaged["status"] = "interrupted";
  damaged["seed_search"] = {{"parts", parts}, {"done", {parts}}};
  folder.write("left/diagram.json", damaged.dump());
  CHECK_THAT(misuse({"--skeleton", "--from", "0.743", "--to", "0.747", "--resume", folder.file("left")}),
             Contains("is damaged; compute it anew"));
}
