// SPDX-License-Identifier: GPL-3.0-or-later
// --flow: the fast paths against slower, independent ones, from the command line.
#include "graze_program.hpp"

#include <graze/apps/map/map_plan.hpp>
#include <graze/apps/problem/flow_choice.hpp>

#include <catch2/catch.hpp>

#include <cmath>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

Json with_flow(const std::string& command, std::vector<std::string> options, const std::string& flow,
               const std::string& id = "hertz-damped") {
  options.insert(options.end(), {"--flow", flow, "--json", "-"});
  const Json json = json_of(call(command, id, std::move(options)));
  const Json& given = json["options"];
  if (flow == "automatic") {
    CHECK_FALSE(given.contains("flow"));  // as in results from before the option existed
  } else {
    CHECK(given["flow"] == flow);
  }
  return json;
}

void check_same(const Json& a, const Json& b, double margin) {
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i].get<double>() == Approx(b[i].get<double>()).margin(margin));
}

}  // namespace

TEST_CASE("option --flow: each name selects its method") {
  const Problem hertz = load_problem(problem("hertz-damped"));
  const auto kinds = [&](const std::string& name) {
    std::vector<std::string> list;
    for (std::size_t mode = 0; mode < hertz.system.modes.size(); ++mode)
      list.emplace_back(make_flow(hertz.system, mode, hertz.parameters, {},
                                  {.kind = flow_from(name.empty() ? Json::object() : Json{{"flow", name}})})
                            .kind());
    return list;
  };
  const std::vector<std::string> fast = {"closed form", "regularised Hertz contact"};
  CHECK(kinds("") == fast);
  CHECK(kinds("alone") == fast);
  CHECK(kinds("general") == std::vector<std::string>{"general", "general"});
  // The default carries motions side by side.
  CHECK(FlowChoice{}.kind() == FlowKind::automatic);
  CHECK(FlowChoice{"alone"}.kind() == FlowKind::alone);
}

TEST_CASE("option --flow: a sweep finds the same orbits with every method") {
  const std::vector<std::string> range = {"--from", "0.9", "--to", "0.95", "--step", "0.005"};
  const Json lanes = with_flow("sweep", range, "automatic");
  for (const char* flow : {"alone", "general"}) {
    const Json other = with_flow("sweep", range, flow);
    REQUIRE(other["rows"].size() == 11);
    for (std::size_t k = 0; k < 11; ++k) {
      const Json &row = other["rows"][k], &same = lanes["rows"][k];
      INFO(flow << " " << row["value"]);
      CHECK(row["attractor"]["type"] == "periodic");
      CHECK(row["attractor"]["period"] == same["attractor"]["period"]);
      CHECK(row["attractor"]["impacts"] == same["attractor"]["impacts"]);
      check_same(row["exponents"], same["exponents"], 1e-8);
      check_same(row["attractor"]["state"], same["attractor"]["state"], 1e-8);
    }
  }
}

TEST_CASE("option --flow: basins and spectra too") {
  const std::vector<std::string> starts = {"--x", "-2:1.5:5", "--v", "-2:2:5", "--transient", "300"};
  const Json lanes = with_flow("attractors", starts, "automatic");
  for (const char* flow : {"alone", "general"}) {
    const Json other = with_flow("attractors", starts, flow);
    CHECK(other["basins"] == lanes["basins"]);
    REQUIRE(other["attractors"].size() == lanes["attractors"].size());
    check_same(other["attractors"][0]["exponents"], lanes["attractors"][0]["exponents"], 1e-8);
  }
  // Chaos: averages agree only within their errors.
  const std::vector<std::string> average = {"--set", "eta=0.711", "--settle", "200", "--periods", "2000"};
  const Json fast = with_flow("lyapunov", average, "alone", "newton-elastic");
  const Json general = with_flow("lyapunov", average, "general", "newton-elastic");
  CHECK(fast["attractor"]["type"] == "chaotic");
  CHECK(general["attractor"]["type"] == "chaotic");
  const double difference = fast["exponents"][0].get<double>() - general["exponents"][0].get<double>();
  CHECK(std::abs(difference) <
        6.0 * std::hypot(fast["standard_errors"][0].get<double>(), general["standard_errors"][0].get<double>()));
}

TEST_CASE("option --flow: the choice affects the points of a map and its head records it for continuation") {
  const std::vector<std::string> grid = {"--param", "eta:0.9:0.95:3", "--param", "r:1.5:2:2"};
  const Json lanes = with_flow("map", grid, "automatic"), general = with_flow("map", grid, "general");
  CHECK(plan_of(lanes).options.flow.kind == FlowKind::automatic);
  CHECK(plan_of(general).options.flow.kind == FlowKind::general);
  const Json &a = general["layers"][0], &b = lanes["layers"][0];
  for (const char* what : {"type", "period", "impacts"}) CHECK(a[what] == b[what]);
  REQUIRE(a["lambda_1"].size() == 2);
  for (std::size_t row = 0; row < 2; ++row) check_same(a["lambda_1"][row], b["lambda_1"][row], 1e-8);
}

TEST_CASE("option --flow: invalid choices are refused") {
  const Outcome unknown = call("lyapunov", "hertz-damped", {"--flow", "Alone"});
  CHECK(unknown.code == 2);
  CHECK_THAT(unknown.err, Contains("--flow Alone: must be one of automatic, alone, general (did you mean alone?)"));
  CHECK_THROWS_AS(flow_from(Json{{"flow", "gsl"}}), std::invalid_argument);
  const TemporaryFolder folder;
  const std::vector<std::string> range = {"--from", "0.94", "--to", "0.95", "--step", "0.005"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), range.begin(), range.end());
    return call("sweep", "hertz-damped", more);
  };
  REQUIRE(with({"--out", folder.file("run")}).code == 0);
  const Outcome other = with({"--resume", folder.file("run"), "--flow", "general"});
  CHECK(other.code == 2);
  CHECK_THAT(other.err, Contains("options.flow is not given there and general now"));
}
