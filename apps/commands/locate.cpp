// SPDX-License-Identifier: GPL-3.0-or-later
// graze locate: one special point to full precision.
#include <graze/apps/arguments.hpp>
#include <graze/apps/branch_report.hpp>
#include <graze/apps/commands/command.hpp>
#include <graze/apps/find_orbit.hpp>
#include <graze/apps/interrupt.hpp>
#include <graze/apps/number.hpp>
#include <graze/apps/orbit_report.hpp>
#include <graze/apps/progress.hpp>
#include <graze/apps/result.hpp>

#include <graze/continuation/continuation.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct Options {
  OrbitOptions orbit;
  std::string type, parameter = "eta";
  std::optional<double> near, reach, from;
  OutputOptions output;
};

/// Points that lie on a branch for a reason of their own; EP, UZ and MX are marks of a computation.
const std::vector<std::string>& locatable() {
  static const std::vector<std::string> list = {"PD", "LP", "BP", "NS", "GR"};
  return list;
}

/// How far from --near a point may lie: a twentieth of the value.
double default_reach(double near) { return 0.05 * std::max(std::abs(near), 0.1); }

Json all_options(const Problem& problem, const Options& options, double reach) {
  Json json = options_json(problem, options.orbit);
  json["type"] = options.type;
  json["param"] = options.parameter;
  json["near"] = *options.near;
  json["reach"] = reach;
  if (options.from) json["from"] = *options.from;
  return json;
}

/// The wanted point on the branch of one of these orbits, the nearest of all.
LocateResult locate_on(const Problem& problem, const std::vector<PeriodicOrbit>& orbits, const Options& options, double reach,
                       const Console& console) {
  Progress progress(console.err, console.quiet, "locating");
  ContinuationOptions continuation;
  continuation.parameter = options.parameter;
  continuation.cancelled = interrupted;
  continuation.progress = [&](const Branch& branch) {
    progress.update(-1.0, [&] {
      return fmt::format("{}, {} = {}", counted(branch.points.size(), "point"), branch.parameter,
                         rounded(branch.points.back().value, 7));
    });
  };
  LocateResult best;
  for (const PeriodicOrbit& orbit : orbits) {
    if (interrupted() || orbit.admissible != Admissibility::admissible) continue;
    LocateResult result = locate(problem.system, orbit, point_type(options.type), *options.near, reach, continuation);
    const auto distance = [&](const LocateResult& r) { return std::abs(r.point->value - *options.near); };
    if (result.point && (!best.point || distance(result) < distance(best)))
      best = std::move(result);
    else if (!best.point)
      best.message += (best.message.empty() ? "" : "; ") + result.message;
  }
  return best;
}

int run(const Options& options, const Console& console) {
  check_outputs(options.output, options.orbit.start.file);
  Problem problem = open_problem(options.orbit.start, console);
  const double reach = options.reach.value_or(default_reach(*options.near));
  if (!(reach > 0.0)) throw std::invalid_argument(fmt::format("--reach {}: must be > 0, for example 0.01", reach));
  set_parameter(problem, options.parameter, options.from.value_or(*options.near), options.from ? "--from" : "--near");

  Result result;
  result.json = result_head("point/1", "locate", problem, all_options(problem, options, reach));
  FoundOrbits found = find_orbits(problem, options.orbit, console);
  LocateResult located = locate_on(problem, found.orbits, options, reach, console);
  if (found.status == Status::done && !located.point && !interrupted() && found.origin == "settled") {
    // Another orbit of this period may carry the point.
    console.note(fmt::format("{}; searching for other orbits of period {}", located.message, period_of(problem, options.orbit)));
    FoundOrbits others = search_for_orbits(problem, options.orbit, console);
    std::erase_if(others.orbits, [&](const PeriodicOrbit& o) { return same_orbit(o, found.orbits.front()); });
    const LocateResult more = locate_on(problem, others.orbits, options, reach, console);
    if (more.point) located = more;
  }
  Status status = located.point ? Status::done : interrupted() ? Status::interrupted : Status::failed;
  const std::string message = located.point                  ? ""
                              : interrupted()                ? "interrupted before a point was located"
                              : found.status != Status::done ? found.message
                                                             : located.message;
  set_status(result.json, status, message);
  add_origin(result.json, found);
  result.json["special_point"] = located.point ? special_point_json(*located.point) : Json(nullptr);
  result.text = describe(problem, options.parameter) + "\n\n";
  if (located.point) {
    result.text += special_point_text(*located.point, options.parameter) + "\n" +
                   orbit_text(located.point->orbit, stability_text(*located.point));
    PeriodicOrbit orbit = located.point->orbit;
    result.table = orbits_table({orbit}, false);
    const auto stable =
        std::find(result.table.columns.begin(), result.table.columns.end(), "stable") - result.table.columns.begin();
    result.table.rows.front()[static_cast<std::size_t>(stable)] = stable_cell(stable_at(*located.point));
    result.table.columns.insert(result.table.columns.begin(), {"label", options.parameter, "precision"});
    result.table.rows.front().insert(result.table.rows.front().begin(),
                                     {located.point->label, exact(located.point->value), exact(located.point->precision)});
  }
  if (status != Status::done) console.err << "graze locate: " << message << "\n";
  return deliver(result, options.output, "locate", exit_code(status), console);
}

std::function<int(const Console&)> setup(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_orbit_options(app, options->orbit);
  begin_group(app, "Point");
  add_choice(app, "--type", options->type, locatable(), "what is located", Need::required);
  add_text(app, "--param", options->parameter, "NAME", "continuation parameter (default eta)");
  add_number(app, "--near", options->near, "value of the parameter near which the point lies", Need::required);
  add_number(app, "--reach", options->reach, "how far from --near it may lie (default: 5 % of it)");
  add_number(app, "--from", options->from, "value at which the orbit is found (default: --near)");
  add_output_options(app, options->output, "point/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command locate_command() {
  return {"locate",
          "one special point to full precision",
          "An orbit is found at --near as by `graze orbit` and followed both ways within --reach; the point of the given type "
          "that lies nearest\n"
          "to --near is located by Newton's method on an extended system. Exit 1 and what was met instead, if there is none.",
          {"graze locate data/problems/hertz-damped.toml --type PD --param eta --near 0.92",
           "graze locate data/problems/hertz-damped.toml --type PD --near 0.7433 --period 2"},
          setup};
}

}  // namespace graze::apps
