// SPDX-License-Identifier: GPL-3.0-or-later
// graze diagram without --skeleton: agreement of sweeps and branches, resumption of any interruption, the picture, misuse.
#include "graze_program.hpp"

#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/results/branch_report.hpp>
#include <graze/apps/results/sweep_report.hpp>

#include <graze/continuation/graph/branch_graph.hpp>
#include <graze/continuation/graph/sweep_against_branches.hpp>

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <set>

using namespace graze;
using namespace graze::apps;
using namespace graze::support;
using Catch::Matchers::Contains;

namespace {

/// Upwards from chaos to the 2/3 orbit (GR at eta = 0.732240318), beside which 2/2 is doubled three times: a few seconds.
const std::vector<std::string> range = {"--from", "0.729", "--to", "0.747"};
const std::vector<std::string> sweeps = {"--step", "0.0015", "--samples", "20", "--standard-error", "3e-3"};

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Outcome run(const std::vector<std::string>& more) {
  return call(std::vector<std::string>{"diagram", problem("newton-elastic"), "--max-period", "8", "--quiet"} + more);
}

/// Checks the picture of the diagram: every sample over the branches, and the exponents below on the same axis.
void check_picture(const Json& result, const std::string& file) {
  CHECK(picture_names("graze.diagram/1") == std::vector<std::string>{"diagram", "skeleton", "states", "exponents"});
  const Picture drawn = picture_of(result);
  REQUIRE(drawn.below.size() == 1);
  REQUIRE(drawn.x_range);
  CHECK(drawn.x_range == drawn.below[0].x_range);
  CHECK((*drawn.x_range)[0] < 0.729);
  CHECK((*drawn.x_range)[1] > 0.747);
  CHECK_THAT(drawn.y_label, Contains("x at forcing phase 0"));
  CHECK_THAT(drawn.below[0].y_label, Contains("exponent"));
  REQUIRE(drawn.barriers.size() == 1);  // x = 2 is reached
  CHECK(drawn.barriers[0].position == 2.0);
  const auto titles = [](const Picture& axes) {
    std::vector<std::string> list;
    for (const apps::Curve& curve : axes.curves)
      if (!curve.title.empty()) list.push_back(curve.title);
    return list;
  };
  CHECK_THAT(titles(drawn), Catch::VectorContains(std::string("sweep up")) && Catch::VectorContains(std::string("sweep down")) &&
                                Catch::VectorContains(std::string("period 3")) && Catch::VectorContains(std::string("unstable")));
  CHECK(titles(drawn.below[0]).size() == 4);
  // Every sample is drawn.
  std::size_t samples = 0, dots = 0;
  for (const Json& row : result["rows"]) samples += row["states"].size();
  for (const apps::Curve& curve : drawn.curves)
    if (curve.stroke == Stroke::dots && curve.title.empty()) dots += curve.points.size();
  CHECK(dots == samples);
  const std::string script = gnuplot_script(drawn, "svg");
  CHECK_THAT(script, Contains("set multiplot") && Contains("exponent 1, sweep down") && Contains("PD1"));
  CHECK(read_file(file) == draw(drawn, "svg"));

  // Before the first sweep the branches are drawn alone.
  Json begun = result;
  begun["rows"] = Json::array();
  CHECK(picture_of(begun).below.empty());
  CHECK_NOTHROW(gnuplot_script(picture_of(begun), "svg"));
}

}  // namespace

TEST_CASE("a whole diagram is the skeleton and the sweeps and the two agree") {
  // From eta = 0.747 on the 2/2 orbit, so that the sweep down follows its doublings beside the 2/3 orbit of the sweep up.
  const std::vector<std::string> start = {"--start", "1.6962,0.871"};
  // The same range in reverse.
  const std::vector<std::string> back = {"--from", "0.747", "--to", "0.729"};
  const TemporaryFolder folder;
  const std::string picture = folder.file("diagram.svg");
  const Json whole = json_of(run(back + sweeps + start + std::vector<std::string>{"--plot", picture, "--json", "-"}));
  CHECK(whole["schema"] == "graze.diagram/1");
  CHECK(whole["status"] == "done");
  CHECK(whole["parts"]["skeleton"] == "done");
  CHECK(whole["parts"]["sweeps"] == "done");

  // It has the results of the two commands for its parts.
  const Json skeleton = json_of(run(back + std::vector<std::string>{"--skeleton", "--json", "-"}));
  for (const char* key : {"parameter", "seeds", "branches", "cascades", "cut_off"}) CHECK(whole[key] == skeleton[key]);
  const Json swept =
      json_of(call(std::vector<std::string>{"sweep", problem("newton-elastic"), "--direction", "both", "--quiet", "--json", "-"} +
                   range + sweeps + start));
  REQUIRE(whole["rows"].size() == 2 * 13);
  CHECK(whole["rows"][0]["value"] == 0.729);
  CHECK(whole["rows"] == swept["rows"]);

  // The attractors of the simulation lie on the branches of the continuation.
  const Problem model = problem_of(whole);
  const std::vector<Branch> branches = branches_from_json(whole);
  for (std::size_t i = 0; i < branches.size(); ++i)  // the branches read equal those written, proofs included
    for (const char* part : {"points", "special_points"}) CHECK(json_of(branches[i])[part] == whole["branches"][i][part]);
  const std::vector<SweepRow> rows = value_of<std::vector<SweepRow>>(whole["rows"]);
  std::size_t periodic = 0, chaotic = 0;
  for (const SweepRow& row : rows) {
    INFO(sweep_direction_name(row.direction) << " " << row.value);
    chaotic += row.attractor.type == AttractorType::chaotic ? 1 : 0;
    if (row.attractor.type != AttractorType::periodic || row.attractor.period > 8) continue;
    ++periodic;
    CHECK(std::any_of(branches.begin(), branches.end(),
                      [&](const Branch& branch) { return branch_contains(model.system, branch, row.states, row.value); }));
    std::vector<Vector> beside = row.states;
    for (Vector& state : beside) state[0] -= 1e-3;
    CHECK(std::none_of(branches.begin(), branches.end(),
                       [&](const Branch& branch) { return branch_contains(model.system, branch, beside, row.value); }));
  }
  CHECK(periodic >= 10);
  CHECK(chaotic >= 2);
  CHECK(whole["off_branches"]["compared"] == periodic);
  CHECK(whole["off_branches"]["rows"].empty());
  // Without the branches of period 3 exactly the rows of period 3 lie on no branch.
  std::vector<Branch> others = branches;
  std::erase_if(others, [](const Branch& branch) { return branch.period == 3; });
  const SweepComparison off = compare_sweep_with_branches(model.system, others, rows, 8, 2);
  std::vector<std::size_t> expected;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].attractor.period == 3) expected.push_back(i);
  CHECK_FALSE(expected.empty());
  CHECK(off.rows == expected);
  // The longest period limits the comparison.
  const SweepComparison none = compare_sweep_with_branches(model.system, others, rows, 0);
  CHECK(none.compared == 0);
  CHECK(none.longer == static_cast<std::size_t>(std::count_if(rows.begin(), rows.end(), [](const SweepRow& row) {
          return row.attractor.type == AttractorType::periodic;
        })));

  check_picture(whole, picture);
}

TEST_CASE("a diagram that is interrupted anywhere and resumed gives the same bytes as an uninterrupted one") {
  // Fixed: seeds and branches read from a file changed the rest by rounding, and branches got other numbers.
  const TemporaryFolder folder;
  const std::vector<std::string> all = {"--from", "0.743", "--to", "0.747", "--step", "0.0005", "--samples", "5"};
  const Outcome whole = run(all + std::vector<std::string>{"--out", folder.file("whole")});
  REQUIRE(whole.code == 0);
  const std::string out = folder.file("part");
  Outcome part = run(all + std::vector<std::string>{"--out", out, "--time", "0.02"});
  std::set<std::string> places;
  double time = 0.05;
  for (; part.code != 0; time *= 1.3) {
    REQUIRE(part.code == 1);
    places.insert(Json::parse(read_file(out + "/diagram.json"))["message"].get<std::string>().substr(0, 40));
    part = run(all + std::vector<std::string>{"--resume", out, "--time", fmt::format("{:.3f}", time)});
    REQUIRE(time < 1000.0);
  }
  CHECK(places.size() > 1);
  CHECK(part.out == whole.out);
  for (const char* name : {"/diagram.json", "/diagram.csv"})
    CHECK(read_file(out + name) == read_file(folder.file("whole") + name));
}

TEST_CASE("a diagram continues from its interruption with identical bits and keeps its finished parts") {
  const TemporaryFolder folder;
  const std::string out = folder.file("run"), left = folder.file("left");
  std::filesystem::create_directory(left);
  const std::vector<std::string> all = range + sweeps;
  const Outcome first = run(all + std::vector<std::string>{"--out", out});
  CHECK(first.code == 0);
  CHECK_THAT(first.out, Contains("chaotic windows:") && Contains("lie on branches") && Contains("PD1 of"));
  const std::string whole = read_file(out + "/diagram.json");
  for (const char* name : {"diagram.csv", "diagram-diagram.png", "diagram-skeleton.png", "diagram-states.png"})
    CHECK(std::filesystem::file_size(out + "/" + name) > 0);
  const auto resumed = [&](const Json& part, const std::vector<std::string>& options) {
    folder.write("left/diagram.json", part.dump());
    const Outcome outcome = run(options + std::vector<std::string>{"--resume", left, "--json", "-", "--csv", folder.file("t")});
    CHECK(outcome.code == 0);
    CHECK(outcome.err.empty());
    return outcome.out;
  };
  // Within the sweeps.
  Json part = Json::parse(whole);
  const std::size_t count = part["rows"].size();
  part["status"] = part["parts"]["sweeps"] = "interrupted";
  part["rows"].erase(part["rows"].begin() + 4, part["rows"].end());
  part.erase("chaotic_windows");
  part.erase("off_branches");
  CHECK(resumed(part, all) == whole);
  // Before them, with other options of the sweeps than at first.
  part["rows"] = Json::array();
  part["parts"]["sweeps"] = "not run";
  part["options"]["step"] = 0.1;
  CHECK(resumed(part, all) == whole);
  // A finished skeleton is reused and not computed again: an artificial change of its seeds proves it.
  const std::size_t seeds = part["seeds"].size();
  part["seeds"].erase(0);
  CHECK(Json::parse(resumed(part, all))["seeds"].size() == seeds - 1);
  // Unless another skeleton is requested.
  part["options"]["max_period"] = 4;
  CHECK(Json::parse(resumed(part, all))["seeds"].size() == seeds);
  // From a skeleton alone.
  Json skeleton = Json::parse(whole);
  skeleton["schema"] = "graze.branch/1";
  for (const char* key : {"parts", "rows", "chaotic_windows", "off_branches"}) skeleton.erase(key);
  CHECK(resumed(skeleton, all) == whole);

  const auto refused = [&](const Json& from, const std::vector<std::string>& options) {
    folder.write("left/diagram.json", from.dump());
    const Outcome outcome = run(options + std::vector<std::string>{"--resume", left});
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    return outcome.err;
  };
  const Json complete = Json::parse(whole);
  REQUIRE(complete["rows"].size() == count);
  CHECK_THAT(refused(complete, range), Contains("has sweeps of another start or of other options: "));
  CHECK_THAT(refused(complete, all + std::vector<std::string>{"--start", "0,0.1"}), Contains("has sweeps of another start"));
  CHECK_THAT(refused(complete, range + std::vector<std::string>{"--skeleton"}),
             Contains("is of a whole diagram, which --skeleton would cut down"));
  Json damaged = complete;
  damaged["rows"][3].erase("end");
  CHECK_THAT(refused(damaged, all), Contains("is damaged; compute it anew"));
}

TEST_CASE("chaotic windows are ranges of neighbouring values in each direction separately") {
  const auto row = [](double value, SweepDirection direction, AttractorType type, double exponent) {
    SweepRow out;
    out.value = value;
    out.direction = direction;
    out.attractor.type = type;
    out.attractor.exponents = {exponent, -0.1 - exponent};
    out.attractor.standard_errors = {0.001 * value, 0.001 * value};
    return out;
  };
  using enum AttractorType;
  const std::vector<SweepRow> rows = {row(1, SweepDirection::up, chaotic, 0.01),   row(2, SweepDirection::up, chaotic, 0.03),
                                      row(3, SweepDirection::up, periodic, -0.05), row(4, SweepDirection::up, chaotic, 0.02),
                                      row(4, SweepDirection::down, chaotic, 0.04), row(3, SweepDirection::down, chaotic, 0.02),
                                      row(2, SweepDirection::down, undecided, 0),  row(1, SweepDirection::down, periodic, -0.05)};
  const std::vector<ChaoticWindow> windows = chaotic_windows(rows);
  REQUIRE(windows.size() == 3);
  CHECK(windows[0].from == 1);
  CHECK(windows[0].to == 2);
  CHECK(windows[0].values == 2);
  CHECK(windows[0].largest_exponent == 0.03);
  CHECK(windows[0].standard_error == 0.002);
  CHECK(windows[0].at == 2);
  CHECK(windows[1].from == 4);
  CHECK(windows[1].to == 4);
  CHECK(windows[1].direction == SweepDirection::up);
  CHECK(windows[2].direction == SweepDirection::down);
  CHECK(windows[2].from == 3);
  CHECK(windows[2].to == 4);
  CHECK(windows[2].at == 4);
  CHECK(chaotic_windows({}).empty());
}

TEST_CASE("a whole diagram refuses invalid options before it computes anything") {
  const auto misuse = [](const std::vector<std::string>& more) {
    const Outcome outcome = run(more);
    CHECK(outcome.code == 2);
    CHECK(outcome.out.empty());
    return outcome.err;
  };
  using Words = std::vector<std::string>;
  CHECK_THAT(misuse(range + Words{"--step", "0"}), Contains("--step is 0; allowed is > 0"));
  CHECK_THAT(misuse(range + Words{"--step", "1e-9"}), Contains("at most a million"));
  CHECK_THAT(misuse(range + Words{"--standard-error", "-1"}), Contains("--standard-error is -1; allowed is > 0"));
  CHECK_THAT(misuse(range + Words{"--samples", "0"}), Contains("--samples 0"));
  CHECK_THAT(misuse(range + Words{"--start", "2.5,0"}), Contains("2.5"));
  CHECK_THAT(misuse(range + Words{"--plot-kind", "multipliers"}),
             Contains("--plot-kind multipliers: without --skeleton it is one of diagram, skeleton, states, exponents"));
  CHECK_THAT(misuse({"--from", "0.7", "--to", "0.7"}), Contains("--from 0.7 and --to 0.7: the range is empty; they must differ"));
}

TEST_CASE("Ctrl-C in the skeleton leaves a diagram without sweeps") {
  const TemporaryFolder folder;
  const Json json = interrupted_json("diagram " + problem("hertz-damped") + " --from 0.65 --to 0.95 --threads 1",
                                     folder.file("r.json"), "skeleton");
  CHECK(json["schema"] == "graze.diagram/1");
  CHECK(json["parts"]["skeleton"] == "interrupted");
  CHECK(json["parts"]["sweeps"] == "not run");
  CHECK(json["rows"].empty());
}
