// SPDX-License-Identifier: GPL-3.0-or-later
// graze diagram --skeleton: every branch in a range of a parameter that hangs together with the orbits found there.
#include <graze/apps/arguments.hpp>
#include <graze/apps/branch_reading.hpp>
#include <graze/apps/branch_report.hpp>
#include <graze/apps/cascades.hpp>
#include <graze/apps/commands/command.hpp>
#include <graze/apps/find_orbit.hpp>
#include <graze/apps/input_file.hpp>
#include <graze/apps/interrupt.hpp>
#include <graze/apps/number.hpp>
#include <graze/apps/orbit_report.hpp>
#include <graze/apps/progress.hpp>
#include <graze/apps/result.hpp>

#include <graze/continuation/skeleton.hpp>
#include <graze/lib/oscillator.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct Options {
  StartOptions start;
  std::string parameter = "eta";
  std::optional<double> from, to;
  bool skeleton = false;
  int max_period = 16, max_branches = 500, seed = 1;
  std::optional<double> max_step;
  std::string resume;
  OutputOptions output;
};

/// The orbits without impact, wherever there are some: the shortest way to every first grazing.
std::vector<PeriodicOrbit> impactless(const Problem& problem, const std::string& name, double from, double to) {
  constexpr int values = 9;
  std::vector<PeriodicOrbit> list;
  for (int i = 0; i < values; ++i) {
    Problem at = problem;
    set_parameter(at, name, from + i * (to - from) / (values - 1));
    const Vector guess = steady_response(at.parameters);
    if (!guess.allFinite() || (at.system.initial_mode && !at.system.initial_mode(0.0, guess, at.parameters))) continue;
    PeriodicOrbit orbit = shoot(at.system, at.parameters, guess, 1);
    if (orbit.converged() && orbit.impacts == 0) list.push_back(std::move(orbit));
  }
  return list;
}

SkeletonOptions skeleton_options(const Options& options, const Problem& problem, const Console& console, Progress& progress) {
  SkeletonOptions out;
  ContinuationOptions& following = out.continuation;
  following.parameter = options.parameter;
  following.from = *options.from;
  following.to = *options.to;
  following.max_period = options.max_period;
  following.max_branches = options.max_branches;
  following.threads = console.thread_count();
  if (options.max_step) following.trace.max_step = *options.max_step;
  following.cancelled = interrupted;
  following.progress = [&progress](const Branch& branch) {
    progress.update(-1.0, [&] {
      return fmt::format("branch {}, period {}: {} points, {} = {}", branch.id, branch.period, branch.points.size(),
                         branch.parameter, rounded(branch.points.back().value, 7));
    });
  };
  out.search.seed = static_cast<unsigned>(options.seed);
  out.more_seeds = impactless(problem, options.parameter, *options.from, *options.to);
  out.progress = [&progress](const std::string& what, double part) { progress.update(part, [&] { return what; }); };
  return out;
}

/// "1/1 2/1 1/2": the labels z = p/n along a branch, each where it changes.
std::string labels_along(const Branch& branch) {
  std::string text, last;
  for (const BranchPoint& point : branch.points) {
    const std::string z = label(point.impacts, branch.period);
    if (z == last) continue;
    text += (text.empty() ? "" : " ") + z;
    last = z;
  }
  return text;
}

Table branches_overview(const std::vector<Branch>& branches, const std::string& parameter) {
  Table table{{"branch", "born at", "period", "z along it", parameter + " from", "to", "points", "stable", "ends"}, {}};
  for (const Branch& branch : branches) {
    if (branch.points.empty()) continue;
    double low = branch.points.front().value, high = low;
    std::size_t stable = 0;
    for (const BranchPoint& point : branch.points) {
      low = std::min(low, point.value);
      high = std::max(high, point.value);
      stable += point.stable ? 1 : 0;
    }
    table.rows.push_back({std::to_string(branch.id),
                          branch.parent ? fmt::format("{} of {}", branch.parent->label, branch.parent->branch) : "seed",
                          std::to_string(branch.period), labels_along(branch), rounded(low, 9), rounded(high, 9),
                          std::to_string(branch.points.size()),
                          stable == 0                      ? "no"
                          : stable == branch.points.size() ? "yes"
                                                           : "in part",
                          std::string(branch_stop_name(branch.stop))});
  }
  return table;
}

Table special_points_overview(const std::vector<Branch>& branches, const std::string& parameter) {
  std::vector<std::pair<const Branch*, const SpecialPoint*>> list;
  for (const Branch& branch : branches)
    for (const SpecialPoint& point : branch.special_points)
      if (point.type != PointType::EP) list.emplace_back(&branch, &point);
  std::stable_sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.second->value > b.second->value; });
  Table table{{"point", parameter, "+-", "branch", "z", "details"}, {}};
  for (const auto& [branch, point] : list) {
    std::string details = point->status == PointStatus::bracketed ? "bracketed" : "";
    for (const char* name : {"criticality", "kind", "scenario"}) {
      const auto found = point->details.find(name);
      if (found != point->details.end()) details += (details.empty() ? "" : ", ") + std::get<std::string>(found->second);
    }
    table.rows.push_back({point->label, rounded(point->value, 12), rounded(point->precision, 2), std::to_string(branch->id),
                          label(point->orbit.impacts, point->orbit.period), details});
  }
  return table;
}

Json seeds_json(const std::vector<SkeletonSeed>& seeds, std::size_t parameter) {
  Json list = Json::array();
  for (const SkeletonSeed& seed : seeds)
    list.push_back({{"value", seed.orbit.parameters[static_cast<Eigen::Index>(parameter)]},
                    {"period", seed.orbit.period},
                    {"impacts", seed.orbit.impacts},
                    {"state", to_json(seed.orbit.state)},
                    {"stable", seed.orbit.stable()},
                    {"origin", seed.origin}});
  return list;
}

/// The branches of an earlier run, if it was one of the same model over the same range.
std::vector<Branch> earlier_branches(const Json& earlier, const Options& options, const Problem& problem) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(fmt::format("--resume: {}/diagram.json {}", options.resume, why));
  };
  const Problem before = problem_of(earlier);
  const auto index = static_cast<Eigen::Index>(parameter_index(problem.system.parameters, options.parameter));
  Vector a = problem.parameters, b = before.parameters;
  if (a.size() == b.size()) a[index] = b[index] = 0.0;
  const Json given = earlier.value("options", Json::object());
  if (before.oscillator != problem.oscillator || before.contact != problem.contact || a != b)
    refuse("is of another model or of other parameters; give the same problem and settings");
  if (given.value("param", "") != options.parameter || given.value("from", 0.0) != *options.from ||
      given.value("to", 0.0) != *options.to)
    refuse(fmt::format("is over another range: {} from {} to {}", given.value("param", ""), exact(given.value("from", 0.0)),
                       exact(given.value("to", 0.0))));
  return branches_from_json(earlier);
}

int run(const Options& given, const Console& console) {
  Options options = given;
  Json earlier;
  if (!options.resume.empty()) earlier = read_to_resume(options.resume, "diagram");
  if (!options.resume.empty() && options.output.out.empty()) options.output.out = options.resume;
  if (!options.skeleton)
    throw std::invalid_argument("diagram draws the skeleton of branches so far and nothing else: give --skeleton");
  check_outputs(options.output, options.start.file);
  if (options.max_step && !(*options.max_step > 0.0)) throw std::invalid_argument("--max-step must be > 0");
  const Problem problem = open_problem(options.start, console);
  Problem at_end = problem;  // a wrong value is found out now
  set_parameter(at_end, options.parameter, *options.from, "--from");
  set_parameter(at_end, options.parameter, *options.to, "--to");
  if (*options.from == *options.to)
    throw std::invalid_argument(fmt::format("--from and --to are both {}; a range has two different ends", exact(*options.to)));
  std::vector<Branch> so_far;
  if (!options.resume.empty()) so_far = earlier_branches(earlier, options, problem);
  Skeleton found;
  {
    Progress progress(console.err, console.quiet, "skeleton");
    SkeletonOptions computing = skeleton_options(options, problem, console, progress);
    computing.so_far = std::move(so_far);
    found = skeleton(problem.system, problem.parameters, computing);
  }
  const std::vector<Branch>& branches = found.graph.branches;
  Status status = Status::done;
  std::string message;
  if (found.graph.interrupted) {
    status = Status::interrupted;
    message = fmt::format("interrupted; {} branches were complete or begun by then", branches.size());
  } else if (branches.empty()) {
    status = Status::failed;
    message = fmt::format("no periodic orbit was found for {} in [{}, {}]", options.parameter, exact(*options.from),
                          exact(*options.to));
  }
  Json all_options = options_json(problem, options.start);
  all_options.update({{"param", options.parameter},
                      {"from", *options.from},
                      {"to", *options.to},
                      {"skeleton", true},
                      {"max_period", options.max_period},
                      {"max_branches", options.max_branches},
                      {"seed", options.seed}});
  if (options.max_step) all_options["max_step"] = *options.max_step;
  Result result;
  result.json = result_head("branch/1", "diagram", problem, all_options);
  result.json["parameter"] = options.parameter;
  set_status(result.json, status, message);
  result.json["seeds"] = seeds_json(found.seeds, parameter_index(problem.system.parameters, options.parameter));
  result.json["branches"] = Json::array();
  for (const Branch& branch : branches) result.json["branches"].push_back(branch_json(branch));
  const std::vector<Cascade> doublings = cascades(branches);
  result.json["cascades"] = cascades_json(doublings);
  result.json["cut_off"] = Json::array();
  for (const CutOff& cut : found.graph.cut_off)
    result.json["cut_off"].push_back({{"branch", cut.branch}, {"label", cut.label}, {"reason", cut.reason}});
  result.table = branches_table(branches);
  result.text = describe(problem, options.parameter) + "\n\n" +
                fmt::format("{}, {}\n", counted(found.seeds.size(), "seed"),
                            branches.size() == 1 ? "1 branch" : fmt::format("{} branches", branches.size())) +
                aligned(branches_overview(branches, options.parameter)) + "\n" +
                aligned(special_points_overview(branches, options.parameter)) + cascades_text(doublings, options.parameter);
  if (!found.graph.cut_off.empty()) {
    result.text += fmt::format("\nnot followed ({}):\n", found.graph.cut_off.size());
    for (const CutOff& cut : found.graph.cut_off)
      result.text += cut.branch == 0 ? fmt::format("  a seed: {}\n", cut.reason)
                                     : fmt::format("  {} of branch {}: {}\n", cut.label, cut.branch, cut.reason);
  }
  if (status != Status::done) console.err << "graze diagram: " << message << "\n";
  return deliver(result, options.output, "diagram", exit_code(status), console);
}

std::function<int(const Console&)> setup(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_start_options(app, options->start);
  begin_group(app, "Diagram");
  add_flag(app, "--skeleton", options->skeleton, "all branches, stable and unstable, with their special points");
  add_text(app, "--param", options->parameter, "NAME", "parameter (default eta)");
  add_number(app, "--from", options->from, "one end of its range", Need::required);
  add_number(app, "--to", options->to, "the other end", Need::required);
  add_count(app, "--max-period", options->max_period, 1, "longest period that is followed (default 16)");
  add_count(app, "--max-branches", options->max_branches, 1, "most branches; what is cut off is listed (default 500)");
  add_count(app, "--seed", options->seed, 0, "of the global search (default 1)");
  add_number(app, "--max-step", options->max_step, "largest step of arclength");
  add_text(app, "--resume", options->resume, "DIR", "go on from the result that an interrupted run left in DIR (its --out)");
  add_output_options(app, options->output, "branch/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command diagram_command() {
  return {
      "diagram",
      "the skeleton of a range: every branch that hangs together with the orbits found there",
      "Seeds are the orbits without impact, what the motion settles on (from rest, sweeping up, sweeping down), and orbits of\n"
      "period 1 to 4 from a global search. From them everything is followed both ways, through folds, period doublings and\n"
      "grazings. A family is kept once. What was not followed is listed. Ctrl-C keeps what is there.\n"
      "Cascades of period doublings are listed with the ratios of their intervals. The picture is the kind skeleton: colours "
      "are\n"
      "periods, marks are special points, z stands along the branches.",
      {"graze diagram data/problems/hertz-damped.toml --skeleton --param eta --from 0.65 --to 0.95 --plot skeleton.png",
       "graze diagram data/problems/newton-elastic.toml --skeleton --from 0.65 --to 0.95 --json skeleton.json"},
      setup};
}

}  // namespace graze::apps
