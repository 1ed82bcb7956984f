// SPDX-License-Identifier: GPL-3.0-or-later
// graze continue: a branch of orbits in one parameter, the branches born on it, and their special points.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/results/branch_report.hpp>
#include <graze/apps/results/cascades.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/skeleton_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/continuation/graph/continuation.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr std::size_t rows_shown = 40;  // of a branch's table, without --all

struct ContinueArguments {
  OrbitOptions orbit;
  std::string parameter;
  std::optional<double> from, to, max_step;
  int switches = 1, multiples = 1;
  std::optional<int> max_points;
  bool both = false, all = false;
  std::vector<double> user_values;
  std::vector<std::string> quantities;
  OutputOptions output;
};

/// Whether a branch ended at a regular end, rather than because the computation could not continue.
bool ended_well(const Branch& branch) {
  return branch.stop == BranchStop::reached_bound || branch.stop == BranchStop::parameter_range ||
         branch.stop == BranchStop::grazing || branch.stop == BranchStop::chatter || branch.stop == BranchStop::returned ||
         branch.stop == BranchStop::equilibrium;
}

ContinuationOptions continuation_options(const ContinueArguments& options, double start, Progress& progress) {
  ContinuationOptions out;
  out.parameter = options.parameter;
  out.to = *options.to;
  out.from = start;
  out.switch_generations = options.switches;
  out.max_multiple = options.multiples;
  out.both_directions = options.both;
  if (options.max_step) out.trace.max_step = *options.max_step;
  if (options.max_points) out.trace.max_points = *options.max_points;
  out.user_values = options.user_values;
  out.cancelled = interrupted;
  out.progress = [&progress, start, to = *options.to](const Branch& branch) {
    const double value = branch.points.back().value;
    progress.update((value - start) / (to - start), [&] {
      return fmt::format("branch {}, period {}: {}, {} = {}", branch.id, branch.period, counted(branch.points.size(), "point"),
                         branch.parameter, rounded(value, 7));
    });
  };
  return out;
}

Json all_options(const Problem& problem, const ContinueArguments& options) {
  Json json = options_json(problem, options.orbit);
  json["param"] = options.parameter;
  json["from"] = parameter(problem, options.parameter);
  json["to"] = *options.to;
  json["switch"] = options.switches;
  if (options.multiples > 1) json["multiples"] = options.multiples;
  if (options.max_step) json["max_step"] = *options.max_step;
  if (options.max_points) json["max_points"] = *options.max_points;
  if (options.both) json["both"] = true;
  if (!options.user_values.empty()) json["user"] = options.user_values;
  put_quantity_option(json, options.quantities);
  return json;
}

int run(const ContinueArguments& given, const Console& console) {
  ContinueArguments options = given;
  const OutputFolder folder(options.output, "continue", options.orbit.start.file);
  if (options.max_step && !(*options.max_step > 0.0))
    throw std::invalid_argument(fmt::format("--max-step is {}; allowed is > 0", exact(*options.max_step)));
  Problem problem = open_problem(options.orbit.start, console, {options.parameter});
  options.parameter = parameter_name(problem, options.parameter);
  check_parameter_name(problem, options.parameter);
  const Quantities quantities = read_quantities(problem, options.quantities);
  if (options.from) set_parameter(problem, options.parameter, *options.from, "--from");
  const double start = parameter(problem, options.parameter);
  Problem at_end = problem;
  set_parameter(at_end, options.parameter, *options.to, "--to");  // reports a wrong --to now
  if (start == *options.to)
    throw std::invalid_argument(fmt::format("--to {0}: {1} is {0} at the start already", exact(start), options.parameter));

  for (const double value : options.user_values)
    if (!(std::min(start, *options.to) <= value && value <= std::max(start, *options.to)))
      console.note(
          fmt::format("--user {} lies outside {} to {}: it is met only if a branch goes there", value, start, *options.to));

  Result result;
  result.json = result_head("branch/1", "continue", problem, all_options(problem, options));
  folder.check_free_for(result.json);
  result.json["parameter"] = options.parameter;
  const OrbitResult found = find_orbits(problem, options.orbit, console);
  Status status = found.status;
  std::string message = found.message;
  std::vector<Branch> branches;
  if (found.status == Status::done) {
    Progress progress(console.err, console.quiet, "following");
    branches = continue_orbit(problem.system, found.orbits.front(), continuation_options(options, start, progress));
  }
  for (const Branch& branch : branches) {
    if (branch.stop == BranchStop::interrupted || ended_well(branch) || branch.parent) continue;
    status = Status::failed;
    message = fmt::format("branch {} stopped at {} = {}: {}", branch.id, options.parameter, rounded(branch.stop_value, 12),
                          branch.message);
  }
  if (interrupted()) {
    status = Status::interrupted;
    if (!branches.empty())
      message = fmt::format("{} on branch {} at {} = {}", interruption(), branches.back().id, options.parameter,
                            rounded(branches.back().stop_value, 12));
  }
  set_status(result.json, status, message);
  result.json.update(json_of(origin_columns(), found));
  result.json["branches"] = Json::array();
  result.text = describe(problem, options.parameter) + "\n";
  const SamePoints same = same_points(branches);
  const std::vector<BranchQuantities> measured = measure(quantities, problem.system, branches, console.thread_count());
  for (std::size_t b = 0; b < branches.size(); ++b) {
    result.json["branches"].push_back(json_of(branches[b]));
    result.text.append("\n").append(branch_text(problem, branches[b],
                                                options.all ? std::numeric_limits<std::size_t>::max() : rows_shown, same,
                                                measured.empty() ? BranchQuantities{} : measured[b]));
  }
  put_quantities(result.json["branches"], measured);
  put_same_points(result.json["branches"], branches);
  const std::vector<Cascade> doublings = cascades(branches);
  result.json["cascades"] = json_of(doublings);
  result.text += cascades_text(doublings, options.parameter);
  if (!found.orbits.empty()) add_notes(result, branch_notes(problem, found.orbits.front()));
  result.table = branches_table(problem, branches, measured);
  if (status != Status::done) console.err << "graze continue: " << message << "\n";
  return deliver(result, options.output, "continue", exit_code(status), console);
}

Json continue_result_schema() {
  return result_schema("branch/1", "a branch of periodic orbits, and the branches born on it; or the skeleton of a diagram",
                       {object_schema({{"parameter", "name of the varied parameter", JsonForm<std::string>::schema()}}),
                        schema_of(origin_columns()), skeleton_schema()});
}

std::function<int(const Console&)> set_up_continue(CLI::App& app) {
  auto options = std::make_shared<ContinueArguments>();
  add_orbit_options(app, options->orbit);
  begin_group(app, "Branch");
  add_text(app, "--param", options->parameter, "NAME", "continuation parameter (default: the forcing frequency)");
  add_number(app, "--from", options->from, "first value of the parameter (default: the problem's own)");
  add_number(app, "--to", options->to, "last value of the parameter", Need::required);
  add_count(app, "--switch", options->switches, 0,
            "generations of branches born at period doublings and branch points that are followed (default 1)");
  add_count(app, "--multiples", options->multiples, 1,
            "at grazings of a hard contact, follow families of up to N times the period too (default 1: none)");
  add_flag(app, "--both", options->both, "also follow the branch the other way, around a fold, as far as the range goes");
  add_numbers(app, "--user", options->user_values, "value at which a point of type UZ is wanted; repeatable");
  add_number(app, "--max-step", options->max_step, "largest step of arclength");
  add_count(app, "--max-points", options->max_points, 2, "most points of a branch");
  add_flag(app, "--all", options->all, "show every point in the table");
  add_quantity_option(app, options->quantities);
  add_output_options(app, options->output, "branch/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command continue_command() {
  return {
      "continue",
      "a branch of orbits in a parameter, the branches born on it, special points located",
      "The orbit is found as by `graze orbit`, at --from, and followed to --to, around folds. Folds (LP), period doublings\n"
      "(PD), branch points (BP), Neimark-Sacker points (NS) and grazings (GR) are located. The branches born at a PD or a BP\n"
      "are followed too. Each branch gives the reason of its end. With --switch 2 and more, the intervals of a cascade of\n"
      "doublings are compared with Feigenbaum's constant.",
      {"graze continue data/problems/hertz-damped.toml --param eta --from 0.95 --to 0.90 --plot branch.png",
       "graze continue data/problems/hertz-damped.toml --from 0.95 --to 0.70 --switch 2 --json branch.json"},
      set_up_continue,
      {{"branch", continue_result_schema}}};
}

}  // namespace graze::apps
