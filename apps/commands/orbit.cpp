// SPDX-License-Identifier: GPL-3.0-or-later
// graze orbit: one periodic orbit, its multipliers, its contacts, its checks.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/orbit_report.hpp>

#include <fmt/format.h>

#include <memory>

namespace graze::apps {

namespace {

struct Options {
  OrbitOptions orbit;
  OutputOptions output;
};

int run(const Options& options, const Console& console) {
  const OutputFolder folder(options.output, "orbit", options.orbit.start.file);
  const Problem problem = open_problem(options.orbit.start, console);
  Result result;
  result.json = result_head("orbit/1", "orbit", problem, options_json(problem, options.orbit));
  folder.check_free_for(result.json);
  const FoundOrbits found = find_orbits(problem, options.orbit, console);
  set_status(result.json, found.status, found.message);
  result.json["orbit"] =
      found.status != Status::failed && !found.orbits.empty() ? orbit_json(found.orbits.front()) : Json(nullptr);
  if (found.origin != "settled") {
    result.json["orbits"] = Json::array();
    for (const PeriodicOrbit& orbit : found.orbits) result.json["orbits"].push_back(orbit_json(orbit));
  }
  add_origin(result.json, found);

  result.table = orbits_table(problem, found.orbits, false);
  result.text = describe(problem) + "\n\n";
  if (found.orbits.size() > 1) result.text += "orbits found\n" + aligned(orbits_table(problem, found.orbits, true)) + "\n";
  if (options.orbit.search)
    for (const PeriodicOrbit& orbit : found.orbits) result.text += orbit_text(problem, orbit) + "\n";
  else if (!found.orbits.empty())
    result.text += orbit_text(problem, found.orbits.front());
  if (!found.orbits.empty() && !found.remark.empty())
    result.text += fmt::format("\n  {}: found by a search, {}\n", found.remark,
                               found.orbits.front().stable() ? "the orbit above was not reached from the start"
                                                             : "the orbit above is not what the motion settles on");
  if (found.status != Status::done) console.err << "graze orbit: " << found.message << "\n";
  return deliver(result, options.output, "orbit", exit_code(found.status), console);
}

std::function<int(const Console&)> setup(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_orbit_options(app, options->orbit);
  add_output_options(app, options->output, "orbit/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command orbit_command() {
  return {"orbit",
          "one periodic orbit, its multipliers, its contacts, its checks",
          "From --start the motion settles for --settle forcing periods; Newton's method makes an orbit of it. If what it "
          "settles on\n"
          "has another period than --period, or with --search, orbits are searched for all over state space, unstable ones "
          "included.\n"
          "Exit 1 and what was found instead, if there is none.",
          {"graze orbit data/problems/hertz-damped.toml --set eta=0.925",
           "graze orbit data/problems/hertz-damped.toml --set eta=0.85 --period 2 --search --json -"},
          setup};
}

}  // namespace graze::apps
