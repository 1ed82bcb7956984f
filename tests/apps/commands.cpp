// SPDX-License-Identifier: GPL-3.0-or-later
// Results of the commands: numbers, JSON as described in CLI.md, tables, pictures.
#include "graze_program.hpp"

#include <graze/apps/commands/command.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/table.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <cmath>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

/// The JSON of a command that must succeed, with nothing else on stdout.
Json json_of(std::vector<std::string> arguments, int code = 0) {
  arguments.insert(arguments.end(), {"--json", "-", "--quiet"});
  const Outcome outcome = call(arguments);
  INFO(outcome.err);
  CHECK(outcome.code == code);
  const Json json = Json::parse(outcome.out, nullptr, false);
  REQUIRE_FALSE(json.is_discarded());
  for (const char* key : {"schema", "graze", "command", "model", "parameters", "options"}) CHECK(json.contains(key));
  return json;
}

double error(const Json& given, double value) { return std::abs(given.get<double>() - value); }

}  // namespace

TEST_CASE("every command has help with a valid example") {
  CHECK(commands().size() >= 8);
  for (const Command& command : commands()) {
    INFO(command.name);
    const Outcome help = call({command.name, "--help"});
    CHECK(help.code == 0);
    CHECK_THAT(help.out, Contains("Example") && Contains("graze " + command.name) && Contains("--quiet"));
    REQUIRE_FALSE(command.examples.empty());
    CHECK_THAT(call({"--help"}).out, Contains(command.name));
  }
}

TEST_CASE("orbit finds the published damped-Hertz orbit") {
  // State and multipliers at eta = 0.925, computed independently in extended precision (12 and 11 digits).
  const Json result = json_of({"orbit", problem("hertz-damped"), "--set", "eta=0.925"});
  CHECK(result["schema"] == "graze.orbit/1");
  CHECK(result["status"] == "done");
  const Json& orbit = result["orbit"];
  CHECK(error(orbit["state"][0], 2.049196636478) < 1e-12);
  CHECK(error(orbit["state"][1], 1.428407518175) < 1e-12);
  CHECK(error(orbit["multipliers"][0][0], -0.94165004594) < 1e-10);
  CHECK(error(orbit["multipliers"][1][0], -0.42664904192) < 1e-10);
  CHECK(orbit["period"] == 1);
  CHECK(orbit["impacts"] == 1);
  CHECK(orbit["stable"] == true);
  CHECK(orbit["admissible"] == true);
  CHECK(orbit["exponents"].size() == 2);
  CHECK(orbit["checks"]["residual"].get<double>() < 1e-12);
  CHECK(orbit["checks"]["liouville"].get<double>() < 1e-10);
  CHECK(orbit["checks"]["finite_difference"].get<double>() < 1e-8);
  CHECK(orbit["events"].size() == 2);
}

TEST_CASE("an orbit lists its contacts with restitution and energy lost") {
  for (const char* id : {"hertz-damped", "hertz-undamped"}) {
    INFO(id);
    const Json result = json_of({"orbit", problem(id)});
    const Json& orbit = result["orbit"];
    REQUIRE(orbit["contacts"].size() == 1);
    const Json& contact = orbit["contacts"][0];
    const double in = contact["entry_speed"], out = contact["exit_speed"];
    CHECK(contact["restitution"].get<double>() == out / in);
    CHECK(contact["energy_lost"].get<double>() == Approx(0.5 * (in * in - out * out)).epsilon(1e-14));
    CHECK(contact["duration"].get<double>() > 0.0);
    for (const Json& event : orbit["events"]) {
      CHECK(event.contains("restitution") == (event["kind"] == "leave"));
      if (event["kind"] == "leave") CHECK(event["restitution"] == contact["restitution"]);
    }
  }
  const Json hard = json_of({"orbit", problem("newton-elastic"), "--set", "k_r=0.8", "--set", "eta=0.8"});
  for (const Json& event : hard["orbit"]["events"]) CHECK(event["restitution"].get<double>() == Approx(0.8).epsilon(1e-13));
}

TEST_CASE("an orbit that begins in contact has its contact completed") {
  // The published 1/1 orbit has x > r at forcing phase 0.
  const Json orbit = json_of({"orbit", problem("hertz-damped"), "--set", "eta=0.925"})["orbit"];
  CHECK(orbit["state"][0].get<double>() > 2.0);
  REQUIRE(orbit["contacts"].size() == 1);
  CHECK(orbit["contacts"][0]["exit"].get<double>() > orbit["duration"].get<double>());
}

TEST_CASE("a zero multiplier is flagged and its exponent is null") {
  const Json orbit = json_of({"orbit", problem("newton-elastic"), "--set", "k_r=0", "--set", "eta=0.8"})["orbit"];
  CHECK(orbit["zero_multipliers"] == 1);
  CHECK(orbit["exponents"][1].is_null());
  CHECK(orbit["checks"]["liouville"].is_null());
}

TEST_CASE("search returns all orbits of a period and the first is the orbit") {
  const Json result = json_of({"orbit", problem("newton-elastic"), "--set", "eta=0.744", "--search"});
  REQUIRE(result["orbits"].size() >= 1);
  CHECK(result["orbit"] == result["orbits"][0]);
  CHECK(result["origin"] == "search");
  for (const Json& orbit : result["orbits"]) CHECK(orbit["period"] == 1);
}

TEST_CASE("a result records its input and can be recomputed from it") {
  const Json result = json_of({"orbit", problem("hertz-damped"), "--set", "eta=0.93", "--start", "0.5,-1", "--settle", "200"});
  CHECK(result["options"]["start"] == Json({0.5, -1.0}));
  CHECK(result["options"]["settle"] == 200);
  CHECK(result["parameters"]["eta"] == 0.93);
  CHECK(result["parameters"].size() == 7);
  CHECK(json_of({"orbit", problem("hertz-damped"), "--set", "eta=0.93", "--start=0.5,-1", "--settle=200"}) == result);
}

TEST_CASE("physical quantities are noted in the result") {
  const TemporaryFolder folder;
  const std::string file = folder.write(
      "p.toml", "[model]\noscillator = \"linear\"\ncontact = \"hertz\"\n[physical]\nexcitation = \"kinematic\"\nm = 4\nk = 30\n"
                "k_e = 70\nc = 2\na = 0.04\nomega = 4.75\nrho = 0.06\nk_h = 50000\nb_h = 0.5\n");
  const Outcome outcome = call({"orbit", file, "--json", "-"});
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.err, Contains("kinematic excitation") && Contains("xi = 0.7"));
  const Json result = Json::parse(outcome.out);
  CHECK(result["converted_from"]["excitation"] == "kinematic");
  CHECK(result["converted_from"]["k_e"] == 70.0);
}

TEST_CASE("continue follows the branch and locates the published period doubling") {
  const Json result = json_of({"continue", problem("hertz-damped"), "--param", "eta", "--to", "0.90"});
  CHECK(result["schema"] == "graze.branch/1");
  CHECK(result["parameter"] == "eta");
  REQUIRE(result["branches"].size() == 2);
  const Json &first = result["branches"][0], &second = result["branches"][1];
  CHECK(first["parent"].is_null());
  CHECK(first["points"].front()["value"] == 0.95);
  CHECK(first["points"].back()["value"] == 0.9);
  CHECK(first["stop"]["reason"] == "reached_bound");
  CHECK(first["stop"]["at"] == 0.9);
  CHECK(second["parent"]["branch"] == 1);
  CHECK(second["parent"]["label"] == "PD1");
  CHECK(second["period"] == 2);
  CHECK(second["points"].back()["value"] == 0.9);
  bool found = false;
  for (const Json& point : first["special_points"]) {
    if (point["type"] != "PD") continue;
    found = true;
    CHECK(point["label"] == "PD1");
    CHECK(point["status"] == "converged");
    CHECK(error(point["value"], 0.919542643087348) < 1e-12);
    CHECK(error(point["state"][0], 2.051881107966) < 1e-11);
    CHECK(error(point["multipliers"][0][0], -1.0) < 1e-10);
    CHECK(error(point["multipliers"][1][0], -0.40214437228) < 1e-10);
    CHECK(point["details"]["criticality"] == "supercritical");
    CHECK(point["interval"][0] <= point["value"]);
    CHECK(point["interval"][1] >= point["value"]);
    CHECK(point["period"] == 1);
  }
  CHECK(found);
}

TEST_CASE("a branch reports sticking orbits and can be drawn") {
  const TemporaryFolder folder;
  const Outcome outcome = call({"continue", problem("newton-elastic"), "--set", "k_r=0.5", "--set", "r=0.5", "--from", "0.4",
                                "--to", "0.41", "--json", folder.file("b.json"), "--all"});
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("\u221e/1"));
  const Json branch = Json::parse(read_file(folder.file("b.json")))["branches"][0];
  for (const Json& point : branch["points"]) {
    CHECK(point["sticking"] == true);
    CHECK(point["isolated_impacts"] < point["impacts"]);
  }
  const Json smooth = json_of({"continue", problem("newton-elastic"), "--from", "0.95", "--to", "0.94"});
  for (const Json& point : smooth["branches"][0]["points"]) CHECK(!point.contains("sticking"));
  CHECK(call({"plot", folder.file("b.json"), "-o", folder.file("b.svg")}).code == 0);
}

TEST_CASE("continue gives a table row for each point") {
  const TemporaryFolder folder;
  const Outcome outcome = call({"continue", problem("hertz-damped"), "--to", "0.93", "--csv", folder.file("b.csv"), "--json",
                                folder.file("b.json"), "--all"});
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.out, Contains("branch 1: period 1") && Contains("stopped at eta = 0.93"));
  const Table table = parse_csv(read_file(folder.file("b.csv")), "b.csv");
  const Json json = Json::parse(read_file(folder.file("b.json")));
  CHECK(table.rows.size() == json["branches"][0]["points"].size());
  CHECK(table.columns[5] == "eta");
}

TEST_CASE("locate finds one period doubling to full precision") {
  const Json result = json_of({"locate", problem("hertz-damped"), "--type", "PD", "--param", "eta", "--near", "0.92"});
  CHECK(result["schema"] == "graze.point/1");
  const Json& point = result["special_point"];
  CHECK(error(point["value"], 0.919542643087348) < 1e-12);
  CHECK(point["status"] == "converged");
  CHECK(point["details"].contains("criticality"));
}

TEST_CASE("locate reports the points that it met if there is none of the requested type") {
  const Outcome outcome = call({"locate", problem("hertz-damped"), "--type", "NS", "--near", "0.94", "--reach", "0.005"});
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err, Contains("no NS"));
  const Outcome beside = call({"locate", problem("hertz-damped"), "--type", "NS", "--near", "0.92", "--reach", "0.005"});
  CHECK(beside.code == 1);
  CHECK_THAT(beside.err, Contains("no NS") && Contains("PD at 0.919542643"));
}

TEST_CASE("verify agrees for a correct orbit") {
  const Json result = json_of({"verify", problem("hertz-damped"), "--set", "eta=0.925"});
  CHECK(result["schema"] == "graze.verify/1");
  CHECK(result["agrees"] == true);
  REQUIRE(result["orbits"].size() == 1);
  CHECK(result["orbits"][0]["checks"].size() >= 5);
  for (const Json& check : result["orbits"][0]["checks"]) {
    INFO(check["name"]);
    CHECK(check["ok"] == true);
  }
}

TEST_CASE("trajectory: its picture has smooth contacts even for a few samples") {
  const Json result = json_of({"trajectory", problem("hertz-damped"), "--periods", "3", "--samples", "20"});
  REQUIRE(result["samples"].size() == 61);
  const Picture picture = picture_of(result, "phase");
  const auto& points = picture.curves.front().points;
  CHECK(points.size() > 7000);
  double widest = 0.0;  // distance between neighbouring points
  for (std::size_t i = 1; i < points.size(); ++i)
    widest = std::max(widest, std::hypot(points[i][0] - points[i - 1][0], points[i][1] - points[i - 1][1]));
  CHECK(widest < 0.05);
  CHECK(points.back()[0] == result["samples"].back()[1]);
  // For very many periods the samples are drawn as they are.
  Json long_run = result;
  long_run["periods"] = 1000000;
  CHECK(picture_of(long_run, "phase").curves.front().points.size() < 100);
}

TEST_CASE("trajectory gives samples and contacts") {
  const TemporaryFolder folder;
  const Json result = json_of({"trajectory", problem("newton-elastic"), "--start", "-0.169,-0.962", "--set", "eta=0.744",
                               "--settle", "0", "--periods", "4", "--samples", "50", "--csv", folder.file("t.csv")});
  CHECK(result["schema"] == "graze.trajectory/1");
  REQUIRE(result["samples"].size() == 201);
  CHECK(result["samples"][0] == Json({0.0, -0.169, -0.962}));
  CHECK(result["contacts"].size() >= 3);
  CHECK(parse_csv(read_file(folder.file("t.csv")), "t.csv").rows.size() == 201);
  for (const Json& row : result["samples"]) CHECK(row[1].get<double>() <= 2.0);
}

TEST_CASE("poincare gives the requested number of points") {
  const Json strobe = json_of({"poincare", problem("newton-elastic"), "--set", "eta=0.711", "--points", "73", "--settle", "10"});
  CHECK(strobe["schema"] == "graze.poincare/1");
  CHECK(strobe["points"].size() == 73);
  CHECK(strobe["columns"] == Json({"x", "v"}));
  const Json impact = json_of({"poincare", problem("newton-elastic"), "--section", "impact", "--points", "20", "--settle", "10"});
  CHECK(impact["points"].size() == 20);
  for (const Json& point : impact["points"]) {
    CHECK(point[0].get<double>() >= 0.0);
    CHECK(point[0].get<double>() < 6.2831853071795865);
    CHECK(point[1].get<double>() > 0.0);
  }
}

TEST_CASE("an impact section without impacts ends and reports this") {
  const Outcome outcome = call({"poincare", problem("hertz-damped"), "--set", "r=100", "--section", "impact", "--settle", "0"});
  CHECK(outcome.code == 1);
  CHECK_THAT(outcome.err, Contains("no impact in the last 1000 forcing periods"));
}

TEST_CASE("models lists the names allowed in problem files") {
  const Outcome text = call({"models"});
  CHECK(text.code == 0);
  CHECK_THAT(text.out, Contains("cantilever") && Contains("newton") && Contains("k_r") && Contains("[0, 1]") &&
                           Contains("kinematic") && Contains("N/m") && Contains("motions are computed for eta >= 0.0001"));
  const Json json = Json::parse(call({"models", "--json", "-"}).out);
  CHECK(json["schema"] == "graze.models/1");
  CHECK(json["contact_laws"].size() >= 3);
  // The other commands use the same limit.
  const double smallest = json["smallest_eta"];
  CHECK(call("orbit", "newton-elastic", {"--set", fmt::format("eta={}", 0.99 * smallest), "--settle", "1"}).code == 2);
}

TEST_CASE("every result is drawn and plot draws it again") {
  const TemporaryFolder folder;
  const std::string p = problem("hertz-damped");
  const std::vector<std::vector<std::string>> runs = {
      {"orbit", p},  {"continue", p, "--to", "0.93"},     {"locate", p, "--type", "PD", "--near", "0.92"},
      {"verify", p}, {"trajectory", p, "--periods", "2"}, {"poincare", p, "--points", "20"}};
  for (std::vector<std::string> run : runs) {
    INFO(run.front());
    const std::string out = folder.file(run.front());
    run.insert(run.end(), {"--out", out, "--plot", folder.file("first.svg"), "--settle", "300", "--quiet"});
    const Outcome outcome = call(run);
    INFO(outcome.err);
    CHECK(outcome.code == 0);
    const std::string result = out + "/" + run.front() + ".json";
    CHECK(std::filesystem::exists(result));
    CHECK(std::filesystem::exists(out + "/" + run.front() + ".csv"));
    CHECK(call({"plot", result, "-o", folder.file("again.svg")}).code == 0);
    CHECK_THAT(read_file(folder.file("again.svg")), Contains("</svg>"));
    CHECK(call({"plot", out + "/" + run.front() + ".csv", "-o", folder.file("table.svg")}).code == 0);
  }
}
