// SPDX-License-Identifier: GPL-3.0-or-later
// graze sweep: the attractor followed from value to value of a parameter, with its exponents: a bifurcation diagram.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/results/sweep_options.hpp>
#include <graze/apps/results/sweep_report.hpp>
#include <graze/apps/text/long_text.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/lib/numerics/parallel.hpp>

#include <fmt/format.h>

#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct SweepArguments {
  StartOptions start;
  std::string parameter, direction = "up", resume;
  std::optional<double> from, to;
  SweepingOptions sweeping;
  std::vector<std::string> quantities;
  OutputOptions output;
};

std::vector<SweepDirection> directions(const std::string& name) {
  if (name == "both") return {SweepDirection::up, SweepDirection::down};
  return {name == "down" ? SweepDirection::down : SweepDirection::up};
}

/// The rows of an earlier run with the same options.
std::vector<SweepRow> earlier_rows(const Json& earlier, const std::string& folder, const Json& head, std::size_t states) {
  check_same_run(earlier, head, folder);
  std::vector<SweepRow> rows;
  try {
    rows = rows_from(earlier.at("rows"), states);
  } catch (const Json::exception&) {
    throw_not_resumable(folder, "sweep", "is damaged; compute it anew");
  }
  return rows;
}

int run(const SweepArguments& given, const Console& console) {
  SweepArguments options = given;
  if (!options.resume.empty() && options.output.out.empty()) options.output.out = options.resume;
  const OutputFolder folder(options.output, "sweep", options.start.file, options.resume);
  const Problem problem = open_problem(options.start, console, {options.parameter});
  options.parameter = parameter_name(problem, options.parameter);
  check_range(problem, options.parameter, *options.from, *options.to, false);
  check_sweeping(options.sweeping);
  const SweepRange range{options.parameter, *options.from, *options.to, directions(options.direction)};
  check_sweep_start(problem, options.start, range);
  const Quantities quantities = read_quantities(problem, options.quantities);
  Json described = options_json(problem, options.start);
  described.update(
      {{"param", options.parameter}, {"from", *options.from}, {"to", *options.to}, {"direction", options.direction}});
  described.update(sweeping_json(options.sweeping));
  described["max_period"] = options.sweeping.max_period;
  put_quantity_option(described, options.quantities);
  Result result;
  result.json = result_head("sweep/1", "sweep", problem, described);
  folder.check_free_for(result.json);
  result.json["parameter"] = options.parameter;
  std::vector<SweepRow> so_far;
  if (!options.resume.empty()) so_far = earlier_rows(folder.earlier(), options.resume, result.json, problem.system.states);
  const auto with_status = [head = result.json](const SweepOutcome& swept) {
    Json json = head;
    set_status(json, swept.status, swept.message);
    json["rows"] = nullptr;
    return json;
  };
  RowQuantities measured;  // once all rows are finished
  const auto rows_of = [&measured](const SweepOutcome& swept) {
    return LongList{"rows", swept.rows.size(), [&rows = swept.rows, &measured](std::size_t k, std::string& text) {
                      JsonText json(text);
                      write_row(rows[k], json, measured.empty() ? QuantityValues{} : measured[k]);
                    }};
  };
  const RowCheckpoints keeping{checkpoint_interval(options.output), [&](const SweepOutcome& swept) {
                                 keep(with_status(swept), options.output, "sweep", console, rows_of(swept));
                               }};
  SweepOutcome swept = carry_out_sweeps(problem, options.start, range, options.sweeping, console, so_far, keeping);
  measured = measure(quantities, problem, options.parameter, swept.rows, console.thread_count());
  result.json = with_status(swept);
  result.list = rows_of(swept);
  result.csv = [&](const TextSink& sink) {
    samples_csv(problem, swept.rows, options.parameter, console.thread_count(), sink, measured);
  };
  result.text = describe(problem, options.parameter) + "\n\n" + aligned(sweep_overview(swept.rows, options.parameter, measured));
  add_notes(result, order_notes(problem, options.parameter, swept.rows));
  if (swept.status != Status::done)
    console.err << "graze sweep: " << swept.message << resume_advice(swept.status, options.output) << "\n";
  const int code = deliver(result, options.output, "sweep", exit_code(swept.status), console);
  // Releasing hundreds of thousands of rows, each with several lists, takes time: done in parallel.
  in_parallel_on(console.thread_count(), swept.rows.size(), [&](std::size_t k) { swept.rows[k] = {}; });
  return code;
}

Json sweep_result_schema() {
  return result_schema("sweep/1", "the attractor at each value of a parameter",
                       {object_schema({{"parameter", "name of the varied parameter", JsonForm<std::string>::schema()},
                                       {"rows", "in the order in which they are reached", rows_schema()}})});
}

std::function<int(const Console&)> set_up_sweep(CLI::App& app) {
  auto options = std::make_shared<SweepArguments>();
  add_start_options(app, options->start);
  begin_group(app, "Sweep");
  add_text(app, "--param", options->parameter, "NAME", "parameter (default: the forcing frequency)");
  add_number(app, "--from", options->from, "first value of the sweep; with --direction down, the last", Need::required);
  add_number(app, "--to", options->to, "last value of the sweep; with --direction down, the first", Need::required);
  add_choice(app, "--direction", options->direction, {"up", "down", "both"}, "direction of the sweep (default up)");
  add_sweeping_options(app, options->sweeping, Need::required, "step from one value to the next");
  add_count(app, "--max-period", options->sweeping.max_period, 1, "longest period that is recognised (default 256)",
            longest_period);
  add_text(app, "--resume", options->resume, "DIR", "continue an interrupted or killed run with --out DIR");
  add_quantity_option(app, options->quantities);
  add_output_options(app, options->output, "sweep/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command sweep_command() {
  return {"sweep",
          "the attractor followed from value to value of a parameter: bifurcation diagram and exponents",
          "Each value starts from the orbit on which the one before ended, or from where the motion was after its transient\n"
          "(in chaos already after 64 forcing periods of it); up and down show hysteresis. Stretches of values are found at the\n"
          "same time: one begins on the attractor that --start leads to, and stands if the values before it come to the same\n"
          "one. Attractors are told apart as periodic (n, p), chaotic or undecided, with exponents; the table holds the\n"
          "stroboscopic states.",
          {"graze sweep data/problems/hertz-damped.toml --from 0.69 --to 0.75 --step 0.0005 --direction both --plot sweep.png",
           "graze sweep data/problems/newton-elastic.toml --from 0.7 --to 0.76 --step 0.001 --out run"},
          set_up_sweep,
          {{"sweep", sweep_result_schema}}};
}

}  // namespace graze::apps
