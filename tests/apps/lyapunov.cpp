// SPDX-License-Identifier: GPL-3.0-or-later
// graze lyapunov: its JSON on periodic and chaotic attractors, its budget, misuse.
#include "graze_program.hpp"

#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/table.hpp>

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

Json spectrum(std::vector<std::string> more, const std::string& id = "hertz-damped") {
  std::vector<std::string> arguments = {"lyapunov", problem(id), "--quiet", "--json", "-"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const Outcome outcome = call(arguments);
  INFO(outcome.err);
  CHECK(outcome.code == 0);
  return Json::parse(outcome.out);
}

}  // namespace

TEST_CASE("lyapunov on a periodic attractor: the exponents of the multipliers with the time average beside them") {
  const Json json = spectrum({"--set", "eta=0.925"});
  CHECK(json["schema"] == "graze.lyapunov/1");
  CHECK(json["attractor"]["type"] == "periodic");
  CHECK(json["attractor"]["period"] == 1);
  CHECK(json["attractor"]["impacts"] == 1);
  CHECK(json["converged"] == true);
  const double T = 2.0 * 3.14159265358979323846 / 0.925;
  CHECK(json["exponents"][0].get<double>() == Approx(std::log(0.94165004594) / T).epsilon(1e-9));
  CHECK(json["exponents"][1].get<double>() == Approx(std::log(0.42664904192) / T).epsilon(1e-9));
  CHECK(json["standard_errors"][0] == 0.0);
  CHECK(json["time_average"]["exponents"][0].get<double>() == Approx(json["exponents"][0].get<double>()).margin(3e-4));
  CHECK(json["liouville_residual"].get<double>() < 1e-10);
}

TEST_CASE("lyapunov in chaos: positive by many standard errors and the use of the budget is reported") {
  const Json json = spectrum({"--set", "eta=0.711", "--standard-error", "1e-3"}, "newton-elastic");
  CHECK(json["attractor"]["type"] == "chaotic");
  CHECK(json["attractor"]["period"].is_null());
  CHECK(json["converged"] == true);
  CHECK(json["standard_errors"][0].get<double>() < 1e-3);
  CHECK(json["exponents"][0].get<double>() + json["exponents"][1].get<double>() == Approx(-0.1).margin(1e-10));
  CHECK(json["kaplan_yorke"].get<double>() > 1.0);
  const Outcome short_of = call({"lyapunov", problem("newton-elastic"), "--set", "eta=0.711", "--periods", "300"});
  CHECK(short_of.code == 0);
  CHECK_THAT(short_of.err, Contains("the budget of 300 forcing periods is used up"));
  CHECK_THAT(short_of.out, Contains("averaged over 300 forcing periods"));
}

TEST_CASE("lyapunov for a zero multiplier: minus infinity is null in JSON") {
  const Json json = spectrum({"--set", "k_r=0", "--set", "r=1"}, "newton-elastic");
  CHECK(json["exponents"].back().is_null());
}

TEST_CASE("lyapunov: an attractor that sticks has the same label as in graze orbit") {
  const std::vector<std::string> options = {"--set", "k_r=0.5", "--set", "eta=0.3", "--set", "r=0"};
  CHECK_THAT(call("orbit", "newton-elastic", options).out, Contains("z = ∞/1"));
  CHECK_THAT(call("lyapunov", "newton-elastic", options).out, Contains("periodic, z = ∞/1") && Contains("-infinity"));
  const Json attractor = spectrum(options, "newton-elastic")["attractor"];
  CHECK(attractor["sticking"] == true);
  CHECK(attractor["isolated_impacts"] == 0);
  CHECK(attractor["impacts"] > 1);
  CHECK(attractor_name(value_of<Attractor>(attractor)) == "z = ∞/1");
  CHECK_FALSE(spectrum({"--set", "eta=0.925"})["attractor"].contains("sticking"));
}

TEST_CASE("lyapunov: an average taken on the way to an orbit is reported as such") {
  Attractor attractor;
  attractor.type = AttractorType::periodic;
  attractor.period = 34;
  attractor.impacts = attractor.isolated_impacts = 60;
  attractor.state = Vector{{0.6, -0.1}};
  attractor.exponents = {-0.005, -0.075};
  const Problem problem = make_problem("linear", "newton");
  LyapunovSpectrum& average = attractor.time_average;
  average.periods = 200000;
  average.exponents = {0.02, -0.1};
  average.standard_errors = {0.002, 0.002};
  CHECK_THAT(attractor_text(problem, attractor, 64), Contains("by 12.5 standard errors: part of it was the way there"));
  average.standard_errors = {0.01, 0.01};
  CHECK_THAT(attractor_text(problem, attractor, 64), !Contains("the way there"));
}

TEST_CASE("lyapunov over too few periods: standard errors are unknown and not infinite") {
  const TemporaryFolder folder;
  const std::string json = folder.file("a.json"), csv = folder.file("a.csv");
  for (const auto& [id, eta] : {std::pair{"newton-elastic", "eta=0.95"}, {"hertz-damped", "eta=0.72"}}) {
    const Outcome outcome = call("lyapunov", id, {"--set", eta, "--periods", "10", "--json", json, "--csv", csv});
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.out, Contains("unknown") && !Contains("infinity"));
    CHECK(Json::parse(read_file(json))["time_average"]["standard_errors"][0].is_null());
    CHECK(parse_csv(read_file(csv), csv).rows[0][4] == "inf");
  }
  CHECK(error_text(std::nan(""), 2) == "unknown");
  CHECK(exponent_text(-HUGE_VAL, 2) == "-infinity");
  CHECK(exponent_text(std::nan(""), 2) == "unknown");
}

TEST_CASE("lyapunov that uses up its budget ends with 0 and reports this") {
  const Outcome outcome = call({"lyapunov", problem("newton-elastic"), "--set", "eta=0.711", "--periods", "300", "--json", "-"});
  CHECK(outcome.code == 0);
  CHECK_THAT(outcome.err, Contains("the budget of 300 forcing periods is used up") && Contains("--periods gives more"));
  const Json result = Json::parse(outcome.out);
  CHECK(result["status"] == "done");
  CHECK(result["converged"] == false);
  CHECK_THAT(result["message"].get<std::string>(), Contains("the budget of 300 forcing periods is used up"));
}

TEST_CASE("lyapunov refuses invalid options") {
  const auto misuse = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"lyapunov", problem("hertz-damped")});
    const Outcome outcome = call(more);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    return outcome.err;
  };
  CHECK_THAT(misuse({"--periods", "3", "--interval", "5"}), Contains("--periods 3 is less than --interval 5"));
  CHECK_THAT(misuse({"--standard-error=-1"}), Contains("--standard-error is -1; allowed is >= 0"));
  CHECK_THAT(misuse({"--standard-error", "1e-3", "--change", "1e-6"}), Contains("are two ways to end the average"));
  CHECK_THAT(misuse({"--interval", "0"}), Contains("--interval 0"));
  CHECK_THAT(misuse({"--peroids", "3"}), Contains("did you mean"));
}
