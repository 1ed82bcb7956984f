// SPDX-License-Identifier: GPL-3.0-or-later
// graze trajectory: samples and contacts of a run.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/problem/ending.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/motion_report.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr std::size_t contacts_shown = 40;
constexpr double most_samples = 2e6;  // in total; a result is held in memory before it is written

struct TrajectoryArguments {
  StartOptions start;
  int periods = 10, samples = 100;
  std::optional<double> duration;
  std::vector<std::string> expressions;
  OutputOptions output;
};

std::string motion_text(const Problem& problem, const Motion& motion, const ContactList& list, bool by_duration) {
  std::string text = by_duration ? "a time of " + rounded(motion.duration) : counted_periods(problem, motion.periods);
  if (!motion.samples.empty()) text += ", " + counted(motion.samples.size(), "sample");
  text += fmt::format(", {}; {}\n", counted(list.contacts.size(), "contact"), termination_text(motion.termination));
  text += fmt::format("  state at the end {}\n", rounded_state(motion.state, 15));
  std::vector<Contact> shown = list.contacts;
  if (shown.size() > contacts_shown) shown.resize(contacts_shown);
  if (!shown.empty()) text.append("\n").append(aligned(contacts_table(shown)));
  if (list.contacts.size() > shown.size())
    text += fmt::format("  ({} of {} contacts shown; --json has all)\n", shown.size(), list.contacts.size());
  return text;
}

int run(const TrajectoryArguments& given, const Console& console) {
  TrajectoryArguments options = given;
  const OutputFolder folder(options.output, "trajectory", options.start.file);
  if (static_cast<double>(options.periods) * options.samples > most_samples)
    throw std::invalid_argument(fmt::format("--periods {} times --samples {} is more than {} samples; ask for fewer of either",
                                            options.periods, options.samples, static_cast<int>(most_samples)));
  const Problem problem = open_problem(options.start, console);
  const Quantities expressions = read_expressions(problem, options.expressions);
  if (options.duration && is_forced(problem.system))
    throw std::invalid_argument("--duration is for systems without forcing; give the length of the run by --periods");
  if (options.duration && !(*options.duration > 0.0))
    throw std::invalid_argument(fmt::format("--duration is {}; allowed is > 0", exact(*options.duration)));
  // A run of a given duration need not return at all: by default it has no transient counted in returns.
  if (options.duration && !options.start.settle) options.start.settle = 0;
  Json asked = options_json(problem, options.start);
  asked["periods"] = options.periods;
  asked["samples"] = options.samples;
  if (options.duration) asked["duration"] = *options.duration;
  put_quantity_option(asked, options.expressions);
  Result result;
  result.json = result_head("trajectory/1", "trajectory", problem, asked);
  folder.check_free_for(result.json);
  const Settled settled = settle_down(problem, options.start, console);
  Motion motion;
  if (settled.termination == Termination::time) {
    Progress progress(console.err, console.quiet, "running");
    motion = run_motion(problem.system, problem.parameters, settled.state,
                        {.periods = options.periods,
                         .samples = writes_files(options.output) ? options.samples : 0,
                         .stretch = options.duration.value_or(0.0) / options.periods,
                         .cancelled = interrupted,
                         .progress = [&](int done) {
                           progress.update(static_cast<double>(done) / options.periods,
                                           [&] { return fmt::format("{} of {} periods", done, options.periods); });
                         }});
  } else {
    motion.strobe.push_back(settled.state);
    motion.state = settled.state;
    motion.termination = settled.termination;
  }
  append_values(expressions, problem, true, motion.samples);
  const ContactList list = contacts_of_run(motion.events);
  const Status status = motion.termination == Termination::time          ? Status::done
                        : motion.termination == Termination::interrupted ? Status::interrupted
                                                                         : Status::failed;
  const std::string message = status == Status::done
                                  ? ""
                                  : fmt::format("stopped after {} of transient and {} of the run: {}",
                                                counted(static_cast<std::size_t>(settled.periods), "period"),
                                                counted(static_cast<std::size_t>(motion.periods), "period"),
                                                ending_text(problem, motion.termination, motion.strobe.back()));
  set_status(result.json, status, message);
  result.json.update(motion_json(problem, motion, list, expressions));
  result.table.columns = motion_columns(problem, expressions);
  for (const Vector& row : motion.samples) result.table.rows.push_back(table_cells(row));
  result.text = describe(problem) + "\n" + motion_text(problem, motion, list, options.duration.has_value());
  add_notes(result, order_notes(problem, motion.events));
  if (status != Status::done) console.err << "graze trajectory: " << message << "\n";
  return deliver(result, options.output, "trajectory", exit_code(status), console);
}

Json trajectory_result_schema() {
  return result_schema("trajectory/1", "a run of a motion", {schema_of(listed_motion_columns())});
}

std::function<int(const Console&)> set_up_trajectory(CLI::App& app) {
  auto options = std::make_shared<TrajectoryArguments>();
  add_start_options(app, options->start);
  begin_group(app, "Run");
  add_count(app, "--periods", options->periods, 1,
            "forcing periods (returns without forcing) that are recorded, after the transient (default 10)");
  add_count(app, "--samples", options->samples, 1, "samples per forcing period or return (default 100)");
  add_number(app, "--duration", options->duration,
             "without forcing: record so much time in place of returns, cut into --periods parts, by default from the start on");
  add_texts(app, "--y", options->expressions, "EXPRESSION",
            "also record this expression of states, parameters and t, and draw it against time; repeatable");
  add_output_options(app, options->output, "trajectory/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command trajectory_command() {
  return {"trajectory",
          "samples of a run, and its contacts",
          "After --settle forcing periods of transient, --periods are recorded, from tau = 0 at forcing phase 0. Of each "
          "contact: entry and exit\n"
          "speed, duration, equivalent coefficient of restitution, energy lost.",
          {"graze trajectory data/problems/hertz-damped.toml --periods 4 --plot run.png",
           "graze trajectory data/problems/newton-elastic.toml --start -0.169,-0.962 --settle 0 --csv run.csv"},
          set_up_trajectory,
          {{"trajectory", trajectory_result_schema}}};
}

}  // namespace graze::apps
