// SPDX-License-Identifier: GPL-3.0-or-later
// graze diagram: every branch in a parameter range that is connected with the orbits found there, and over it the attractors of
// sweeps up and down, with their exponents.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/checkpoint_timer.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/pictures/pictures.hpp>
#include <graze/apps/results/branch_report.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/input_file.hpp>
#include <graze/apps/results/run_identity.hpp>
#include <graze/apps/results/skeleton_report.hpp>
#include <graze/apps/results/sweep_options.hpp>
#include <graze/apps/results/sweep_report.hpp>
#include <graze/apps/text/json_member.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/continuation/graph/skeleton.hpp>
#include <graze/continuation/graph/sweep_against_branches.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr int usual_steps = 300;  // of a sweep through the range

struct DiagramArguments {
  StartOptions start;
  std::string parameter;
  std::optional<double> from, to;
  bool skeleton = false, all = false;
  int max_period = 16, max_branches = 500, seed = 1;
  std::optional<int> multiples;
  std::optional<double> max_step;
  SweepingOptions sweeping;
  std::string resume;
  std::vector<std::string> quantities;
  OutputOptions output;
};

/// The orbits without impact, if there are any: the shortest way to every first grazing.
std::vector<PeriodicOrbit> impactless(const Problem& problem, const std::string& name, double from, double to) {
  constexpr int values = 9;
  std::vector<PeriodicOrbit> list;
  if (!is_forced(problem.system)) return list;  // without impacts it is at rest
  for (int i = 0; i < values; ++i) {
    Problem at = problem;
    set_parameter(at, name, from + i * (to - from) / (values - 1));
    const Vector guess = is_built_in(at) ? steady_response(built_in_parameters(at)) : rest_state(at, at.parameters);
    if (!mode_at(at.system, 0.0, guess, at.parameters)) continue;
    PeriodicOrbit orbit = shoot(at.system, at.parameters, guess, 1);
    if (orbit.converged() && orbit.impacts == 0) list.push_back(std::move(orbit));
  }
  return list;
}

SkeletonOptions skeleton_options(const DiagramArguments& options, const Problem& problem, const Console& console,
                                 Progress& progress) {
  SkeletonOptions out;
  ContinuationOptions& following = out.continuation;
  following.parameter = options.parameter;
  following.from = *options.from;
  following.to = *options.to;
  following.max_period = options.max_period;
  following.max_branches = options.max_branches;
  following.threads = console.thread_count();
  out.families.all = options.all;
  out.max_multiple = options.multiples.value_or(options.max_period);
  if (options.max_step) following.trace.max_step = *options.max_step;
  following.cancelled = interrupted;
  following.progress = [&progress](const Branch& branch) {
    progress.update(-1.0, [&] {
      return fmt::format("branch {}, period {}: {} points, {} = {}", branch.id, branch.period, branch.points.size(),
                         branch.parameter, rounded(branch.points.back().value, 7));
    });
  };
  if (!is_forced(problem.system)) out.start = start_state(problem, options.start);
  out.search.seed = static_cast<unsigned>(options.seed);
  out.more_seeds = impactless(problem, options.parameter, *options.from, *options.to);
  out.progress = [&progress](const std::string& what, double part) { progress.update(part, [&] { return what; }); };
  return out;
}

/// The options that affect the skeleton; the next function returns those of the sweeps.
Json skeleton_json(const DiagramArguments& options) {
  Json json = {{"max_period", options.max_period}, {"max_branches", options.max_branches}, {"seed", options.seed}};
  json["multiples"] = options.multiples.value_or(options.max_period);
  json["all"] = options.all;
  if (options.max_step) json["max_step"] = *options.max_step;
  return json;
}

Json sweeps_json(const DiagramArguments& options, const Problem& problem) {
  Json json = options_json(problem, options.start);
  json.update(sweeping_json(options.sweeping));
  return json;
}

/// Whether an earlier run has these options. If `optional` is missing here, it must be missing there.
bool same_options(const Json& earlier, const Json& wanted, const char* optional = "") {
  const Json given = earlier.value("options", Json::object());
  for (const auto& [name, value] : wanted.items())
    if (given.value(name, Json()) != value) return false;
  return wanted.contains(optional) || !given.contains(optional);
}

/// The results of an earlier run.
struct Earlier {
  Json result;
  bool skeleton_done = false;
  std::vector<Branch> branches;
  std::vector<CutOff> cut_off;
  PartialSeeds seeds;  // of an unfinished skeleton
  std::vector<SweepRow> rows;
};

/// Writes the results so far, with a message on them.
using KeepPart = std::function<void(const Json& part, const std::string& message)>;

/// @throws std::invalid_argument if the earlier run has another model or range, or cannot be resumed.
void check_earlier(Earlier& earlier, const DiagramArguments& options, const Problem& problem) {
  const auto refuse = [&](const std::string& why) { throw_not_resumable(options.resume, "diagram", why); };
  const Json& result = earlier.result;
  problem_of(result);  // throws if it is invalid
  Json before = identity_of(result, {"model", "parameters"}), wanted = result_head("", "", problem, {});
  before["parameters"].erase(options.parameter);
  wanted["parameters"].erase(options.parameter);
  if (const auto found = difference(before, identity_of(wanted, {"model", "parameters"})))
    refuse(fmt::format("is of another run: {}; give the same problem and settings", *found));
  const Json given = result.value("options", Json::object());
  const bool whole = schema_of(result) == "graze.diagram/1";
  if (whole && options.skeleton) refuse("is of a whole diagram, which --skeleton would cut down; leave --skeleton out");
  bool same_range = false;
  std::string range;
  try {
    range = fmt::format("{} from {} to {}", text_of(given, "param"), exact(given.at("from")), exact(given.at("to")));
    same_range =
        text_of(given, "param") == options.parameter && given.at("from") == *options.from && given.at("to") == *options.to;
    const bool same = same_options(result, skeleton_json(options), "max_step");
    earlier.skeleton_done = text_of(whole ? result.at("parts") : result, whole ? "skeleton" : "status") == "done" && same;
    earlier.cut_off = value_of<std::vector<CutOff>>(result.at("cut_off"));
    if (earlier.skeleton_done) {  // it will be read when it is shown
      for (const char* key : skeleton_keys) result.at(key);
      skeleton_text(result.at("search"), result.at("seeds").size(), {}, {}, options.parameter);
    }
    if (same && result.contains("seed_search")) earlier.seeds = seeds_from(result, problem, options.parameter);
    if (whole) earlier.rows = rows_from(result.at("rows"), problem.system.states);
  } catch (const std::exception&) {
    refuse("is damaged; compute it anew");
  }
  if (!same_range) refuse("is over another range: " + range);
  earlier.branches = branches_from_json(result);
  if (earlier.rows.empty()) return;
  const Json sweeps = identity_of({{"options", sweeps_json(options, problem)}}, {"options"})["options"];
  for (const auto& [name, value] : sweeps.items())
    if (const auto found = difference({{name, given.value(name, Json())}}, {{name, value}}))
      refuse(fmt::format("has sweeps of another start or of other options: {}; give the same", *found));
}

/// Adds the entries of the sweeps before they are run.
void put_parts(Json& json, const DiagramArguments& options, const Earlier& earlier, Status skeleton) {
  if (options.skeleton) return;
  json["parts"] = {{"skeleton", status_name(skeleton)}, {"sweeps", "not run"}};
  json["rows"] = rows_json(earlier.rows);
}

/// Adds the skeleton to the result. A complete skeleton of the earlier run is reused; otherwise it is computed from the earlier
/// run's seeds. The branches are followed again, because their numbers, and decisions that involve two branches, depend on
/// their order.
Status add_skeleton(Result& result, Earlier& earlier, const DiagramArguments& options, const Problem& problem,
                    const Quantities& quantities, const Console& console, const KeepPart& keep_part) {
  Status status = Status::done;
  if (earlier.skeleton_done) {
    for (const char* key : skeleton_keys) result.json[key] = earlier.result.at(key);
  } else {
    const std::size_t parameter = parameter_index(problem.system.parameters, options.parameter);
    Progress progress(console.err, console.quiet, "skeleton");
    CheckpointTimer checkpoints(checkpoint_interval(options.output), CheckpointTimer::End::goes_on);
    std::size_t told = 0;
    SkeletonOptions computing = skeleton_options(options, problem, console, progress);
    computing.seeds_so_far = std::move(earlier.seeds.seeds);
    computing.searched_so_far = std::move(earlier.seeds.searched);
    computing.keep = [&](const std::function<Skeleton()>& so_far) {
      ++told;
      checkpoints.news();
      if (!checkpoints.over()) return;
      const Skeleton part = so_far();
      Json json = result.json;
      put_skeleton(json, part, parameter, console.thread_count());
      put_parts(json, options, earlier, Status::interrupted);
      keep_part(json, fmt::format("kept with {} branches complete, while it went on", part.graph.branches.size()));
      checkpoints.begin(told);
    };
    checkpoints.begin(told);
    Skeleton found = skeleton(problem.system, problem.parameters, computing);
    put_skeleton(result.json, found, parameter, console.thread_count());
    earlier.branches = std::move(found.graph.branches);
    earlier.cut_off = std::move(found.graph.cut_off);
    if (found.graph.interrupted) status = Status::interrupted;
  }
  if (earlier.branches.empty() && status == Status::done) status = Status::failed;
  const std::vector<BranchQuantities> measured = measure(quantities, problem.system, earlier.branches, console.thread_count());
  put_quantities(result.json["branches"], measured);
  result.table = branches_table(problem, earlier.branches, measured);
  result.text +=
      skeleton_text(result.json["search"], result.json["seeds"].size(), earlier.branches, earlier.cut_off, options.parameter);
  return status;
}

/// The stage at which the skeleton was interrupted.
std::string where_interrupted(const Json& skeleton, std::size_t branches) {
  const std::size_t parts = skeleton.at("seed_search").at("parts"), done = skeleton["seed_search"].at("done").size();
  if (done < parts)
    return fmt::format("{} in the search for seeds; {} of its {} parts were done by then", interruption(), done, parts);
  return fmt::format("{}; {} branches were complete or begun by then", interruption(), branches);
}

/// Whether simulation and continuation agree.
std::string off_branches_text(const SweepComparison& off, const std::vector<SweepRow>& rows, const DiagramArguments& options) {
  std::string text =
      off.rows.empty() ? fmt::format("\nall {} periodic values up to period {} lie on branches", off.compared, options.max_period)
                       : fmt::format("\n{} of {} periodic values up to period {} lie on no branch", off.rows.size(), off.compared,
                                     options.max_period);
  if (off.longer > 0) text += fmt::format("; {} have longer periods", off.longer);
  text += off.rows.empty() ? "\n" : ":\n";
  std::vector<SweepRow> list;
  for (const std::size_t i : off.rows) list.push_back(rows[i]);
  return list.empty() ? text : text + aligned(sweep_overview(list, options.parameter));
}

/// Runs the sweeps up and down over the range, and adds them to the result.
SweepOutcome add_sweeps(Result& result, const Earlier& earlier, const SweepRange& range, const DiagramArguments& options,
                        const Problem& problem, const Quantities& quantities, const Console& console, const KeepPart& keep_part) {
  const auto keep_rows = [&](const SweepOutcome& part) {
    Json json = result.json;
    json["parts"]["sweeps"] = status_name(part.status);
    json["rows"] = rows_json(part.rows);
    keep_part(json, part.message);
  };
  SweepOutcome swept = carry_out_sweeps(problem, options.start, range, options.sweeping, console, earlier.rows,
                                        {checkpoint_interval(options.output), keep_rows});
  const std::vector<ChaoticWindow> windows = chaotic_windows(swept.rows);
  const RowQuantities measured = measure(quantities, problem, options.parameter, swept.rows, console.thread_count());
  result.json["rows"] = rows_json(swept.rows, measured);
  result.json["chaotic_windows"] = json_of(windows);
  result.text += "\n" + aligned(sweep_overview(swept.rows, options.parameter, measured)) + "\n";
  result.text += windows.empty() ? "no chaos on the way\n"
                                 : "chaotic windows:\n" + aligned(chaotic_windows_table(windows, options.parameter));
  add_notes(result, order_notes(problem, options.parameter, swept.rows));
  if (swept.status == Status::interrupted) return swept;
  const SweepComparison off =
      compare_sweep_with_branches(problem.system, earlier.branches, swept.rows, options.max_period, console.thread_count());
  result.json["off_branches"] = {{"compared", off.compared}, {"longer", off.longer}, {"rows", off.rows}};
  result.text += off_branches_text(off, swept.rows, options);
  return swept;
}

/// Checks that this result has the requested kind of picture. @throws std::invalid_argument.
void check_plot_kind(const DiagramArguments& options) {
  const std::vector<std::string> kinds = picture_names(options.skeleton ? "graze.branch/1" : "graze.diagram/1");
  if (!options.output.plot_kind.empty() && std::find(kinds.begin(), kinds.end(), options.output.plot_kind) == kinds.end())
    throw std::invalid_argument(fmt::format("--plot-kind {}: {} --skeleton it is one of {}", options.output.plot_kind,
                                            options.skeleton ? "with" : "without", fmt::join(kinds, ", ")));
}

SweepRange range_of(const DiagramArguments& options) {
  return {options.parameter,
          std::min(*options.from, *options.to),
          std::max(*options.from, *options.to),
          {SweepDirection::up, SweepDirection::down}};
}

/// Reports every mistake before anything is computed.
void check_options(DiagramArguments& options, const Problem& problem) {
  if (options.max_step && !(*options.max_step > 0.0))
    throw std::invalid_argument(fmt::format("--max-step is {}; allowed is > 0", exact(*options.max_step)));
  check_sweeping(options.sweeping);
  check_range(problem, options.parameter, *options.from, *options.to, true);
  if (options.skeleton && (options.sweeping.step || options.sweeping.standard_error))
    throw std::invalid_argument(
        fmt::format("{} belongs to the sweeps, and --skeleton has none", options.sweeping.step ? "--step" : "--standard-error"));
  if (options.skeleton) return;
  const SweepRange range = range_of(options);
  check_sweep_start(problem, options.start, range);
  if (!options.sweeping.step) options.sweeping.step = (range.to - range.from) / usual_steps;
  sweep_values(range.from, range.to, *options.sweeping.step);
}

int run(const DiagramArguments& given, const Console& console) {
  DiagramArguments options = given;
  Earlier earlier;
  if (!options.resume.empty() && options.output.out.empty()) options.output.out = options.resume;
  check_plot_kind(options);
  const OutputFolder folder(options.output, "diagram", options.start.file, options.resume);
  earlier.result = folder.earlier();
  const Problem problem = open_problem(options.start, console, {options.parameter});
  options.parameter = parameter_name(problem, options.parameter);
  check_options(options, problem);
  const Quantities quantities = read_quantities(problem, options.quantities);
  if (!options.resume.empty()) check_earlier(earlier, options, problem);
  Json described = options_json(problem, options.start);
  described.update({{"param", options.parameter}, {"from", *options.from}, {"to", *options.to}, {"skeleton", options.skeleton}});
  described.update(skeleton_json(options));
  if (!options.skeleton) described.update(sweeping_json(options.sweeping));
  put_quantity_option(described, options.quantities);
  const auto complete = [&](Json found, Status status, const std::string& message) {
    Json json = result_head(options.skeleton ? "branch/1" : "diagram/1", "diagram", problem, described);
    json["parameter"] = options.parameter;
    set_status(json, status, message);
    for (auto& item : found.items()) json[item.key()] = std::move(item.value());
    return json;
  };
  folder.check_free_for(complete(Json::object(), Status::done, {}));
  const KeepPart keep_part = [&](const Json& part, const std::string& message) {
    keep(complete(part, Status::interrupted, message), options.output, "diagram", console);
  };
  Result result;
  result.text = describe(problem, options.parameter) + "\n\n";
  Status status = add_skeleton(result, earlier, options, problem, quantities, console, keep_part);
  put_parts(result.json, options, earlier, status);
  std::string message;
  if (status == Status::interrupted) message = where_interrupted(result.json, earlier.branches.size());
  if (status == Status::failed)
    message = fmt::format("no periodic orbit was found for {} in [{}, {}]", options.parameter, exact(*options.from),
                          exact(*options.to));
  if (!options.skeleton && status != Status::interrupted) {
    const SweepOutcome swept = add_sweeps(result, earlier, range_of(options), options, problem, quantities, console, keep_part);
    result.json["parts"]["sweeps"] = status_name(swept.status);
    if (status == Status::done || swept.status == Status::interrupted) message = swept.message;
    if (swept.status != Status::done) status = swept.status;
  }
  result.json = complete(std::move(result.json), status, message);
  if (status != Status::done) console.err << "graze diagram: " << message << resume_advice(status, options.output) << "\n";
  return deliver(result, options.output, "diagram", exit_code(status), console);
}

Json diagram_result_schema() {
  const Json text = JsonForm<std::string>::schema(), count = JsonForm<int>::schema();
  const Json off = object_schema({{"compared", "periodic rows with periods up to --max-period", count},
                                  {"longer", "rows with longer ones", count},
                                  {"rows", "numbers, from 0, of those that lie on no branch", list_schema(count)}});
  return result_schema(
      "diagram/1", "sweeps and branches over a range of a parameter",
      {object_schema({{"parameter", "name of the varied parameter", text}}), skeleton_schema(),
       object_schema({{"parts", "how each of them ended",
                       object_schema({{"skeleton", "the branches", text}, {"sweeps", "the rows", text}})},
                      {"rows", "of the sweeps", rows_schema()},
                      {"chaotic_windows", "in the sweeps", JsonForm<std::vector<ChaoticWindow>>::schema(), false},
                      {"off_branches", "sweeps against branches", off, false}})});
}

std::function<int(const Console&)> set_up_diagram(CLI::App& app) {
  auto options = std::make_shared<DiagramArguments>();
  add_start_options(app, options->start);
  begin_group(app, "Diagram");
  add_text(app, "--param", options->parameter, "NAME", "parameter (default: the forcing frequency)");
  add_number(app, "--from", options->from, "one end of the range", Need::required);
  add_number(app, "--to", options->to, "other end of the range", Need::required);
  add_flag(app, "--skeleton", options->skeleton, "the skeleton alone, without sweeps (graze.branch/1)");
  add_text(app, "--resume", options->resume, "DIR", "continue an interrupted or killed run with --out DIR");
  add_quantity_option(app, options->quantities);
  begin_group(app, "Skeleton");
  add_count(app, "--max-period", options->max_period, 1, "longest period that is followed (default 16)");
  add_count(app, "--multiples", options->multiples, 1,
            "at grazings of a hard contact, follow families of up to N times the period (default: to --max-period; 1: none)");
  add_flag(app, "--all", options->all,
           "keep branches that are stable nowhere, too: search for unstable orbits, follow all branches");
  add_count(app, "--max-branches", options->max_branches, 1, "most branches; those left out are listed (default 500)");
  add_count(app, "--seed", options->seed, 0, "seed of the global search (default 1)");
  add_number(app, "--max-step", options->max_step, "largest step of arclength");
  begin_group(app, "Sweeps");
  add_sweeping_options(app, options->sweeping, Need::optional,
                       fmt::format("step from one value to the next (default: a {}th of the range)", usual_steps));
  add_output_options(app, options->output, "diagram/1", "branch/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command diagram_command() {
  return {
      "diagram",
      "the whole picture of a range: sweeps up and down on the skeleton of branches, exponents below",
      "First the skeleton. Seeds are the orbits without impact, the attractors reached (from rest, sweeping up, sweeping\n"
      "down), and stable orbits of every period up to --max-period from many starts at 121 values. From them branches are\n"
      "followed both ways, through folds, period doublings and grazings. Kept are those that are stable somewhere, and those\n"
      "that bound them: on which they are born or end. A series towards complete chatter is followed to its accumulation, not\n"
      "impact by impact. --all keeps and follows all, and searches for unstable orbits of period 1 to 4 too. A family is kept\n"
      "once. Branches that were left out are listed, and cascades of period doublings with the ratios of their intervals.\n"
      "Then the attractors are followed up and down, with exponents: --start and --settle say from where. Chaotic windows are\n"
      "listed, and stable orbits of the sweeps that lie on no branch, where there are any.\n"
      "Ctrl-C keeps the partial result. --resume goes on from the seeds, the skeleton and the sweeps that are complete, and\n"
      "comes to the same result as without interruption, to the last bit. The table (--csv) is that of the branches; the\n"
      "samples of the sweeps are \"rows\" in the JSON, as in that of graze sweep.",
      {"graze diagram data/problems/hertz-damped.toml --from 0.65 --to 0.95 --plot diagram.png",
       "graze diagram data/problems/newton-elastic.toml --skeleton --param eta --from 0.65 --to 0.95 --plot skeleton.png"},
      set_up_diagram,
      {{"diagram", diagram_result_schema}}};
}

}  // namespace graze::apps
