// SPDX-License-Identifier: GPL-3.0-or-later
// A further command, `settled`: the state on which a motion settles, in JSON and as a picture.
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/program/program.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include <CLI/CLI.hpp>

#include <memory>

using namespace graze;
using namespace graze::apps;

namespace {

struct Options {
  std::string file;
  int periods = 1000;
  OutputOptions output;
};

int run(const Options& options, const Console& console) {
  const Problem problem = load_problem(options.file);
  const Vector rest = Vector::Zero(static_cast<Eigen::Index>(problem.system.states));
  const Settled settled = settle(problem.system, problem.parameters, problem.start.value_or(rest), {.periods = options.periods});
  Result result;
  result.json = result_head("settled/1", "settled", problem, {{"periods", options.periods}});
  set_status(result.json, settled.termination == Termination::time ? Status::done : Status::failed);
  for (const double x : settled.state) result.json["state"].push_back(x);
  result.text = result.json["state"].dump() + "\n";
  return deliver(result, options.output, "settled", 0, console);
}

Json schema() { return {{"type", "object"}, {"required", {"schema", "state"}}}; }

Command settled_command() {
  return {.name = "settled",
          .summary = "the state on which a motion settles",
          .details = "Simulates a transient and prints the state behind it.",
          .examples = {"own_program settled data/problems/hertz-damped.toml"},
          .setup = [](CLI::App& app) -> std::function<int(const Console&)> {
            const auto options = std::make_shared<Options>();
            add_text(app, "PROBLEM", options->file, "FILE", "the problem file", Need::required);
            add_count(app, "--periods", options->periods, 0, "length of the transient");
            add_output_options(app, options->output, "settled/1");
            return [options](const Console& console) { return run(*options, console); };
          },
          .results = {{"settled", schema}}};
}

PictureKind settled_picture() {
  return {.schema = "graze.settled/1", .name = "states", .summary = "the states by number", .draw = [](const Json& result) {
            Picture picture;
            picture.x_label = "state";
            Curve& curve = picture.curves.emplace_back();
            curve.stroke = Stroke::dots;
            for (const Json& x : result.at("state")) curve.points.push_back({static_cast<double>(curve.points.size()), x, 0.0});
            return picture;
          }};
}

}  // namespace

Command resonances_command();  // resonances.cpp

int main(int argc, char** argv) { return run_main(argc, argv, {{settled_command(), resonances_command()}, {settled_picture()}}); }
