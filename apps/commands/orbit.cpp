// SPDX-License-Identifier: GPL-3.0-or-later
// graze orbit: one periodic orbit, its multipliers, its contacts, its checks.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/orbit_report.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <memory>

namespace graze::apps {

namespace {

struct OrbitArguments {
  OrbitOptions orbit;
  std::vector<std::string> quantities;
  OutputOptions output;
};

int run(const OrbitArguments& options, const Console& console) {
  const OutputFolder folder(options.output, "orbit", options.orbit.start.file);
  const Problem problem = open_problem(options.orbit.start, console);
  const Quantities quantities = read_quantities(problem, options.quantities);
  Json asked = options_json(problem, options.orbit);
  put_quantity_option(asked, options.quantities);
  Result result;
  result.json = result_head("orbit/1", "orbit", problem, asked);
  folder.check_free_for(result.json);
  const OrbitResult found = find_orbits(problem, options.orbit, console);
  set_status(result.json, found.status, found.message);
  std::vector<QuantityValues> measured;
  Json orbits = Json::array();
  for (const PeriodicOrbit& orbit : found.orbits) {
    measured.push_back(measure(quantities, problem.system, orbit));
    orbits.push_back(json_of(orbit));
    put_quantities(orbits.back(), measured.back());
  }
  result.json["orbit"] = found.status != Status::failed && !found.orbits.empty() ? orbits.front() : Json(nullptr);
  if (found.origin != OrbitOrigin::settled) result.json["orbits"] = std::move(orbits);
  result.json.update(json_of(origin_columns(), found));

  result.table = orbits_table(problem, found.orbits, false, measured);
  result.text = describe(problem) + "\n\n";
  if (found.orbits.size() > 1)
    result.text += "orbits found\n" + aligned(orbits_table(problem, found.orbits, true, measured)) + "\n";
  for (std::size_t i = 0; i < (options.orbit.search ? found.orbits.size() : std::min<std::size_t>(1, found.orbits.size())); ++i)
    result.text += orbit_text(problem, found.orbits[i]) + quantities_text(measured[i]) + (options.orbit.search ? "\n" : "");
  if (!found.orbits.empty() && !found.remark.empty())
    result.text += fmt::format("\n  found by a search, {}: {}\n",
                               found.orbits.front().stable() ? "the orbit above was not reached from the start"
                                                             : "the motion does not settle on the orbit above",
                               found.remark);
  if (!found.orbits.empty()) add_notes(result, order_notes(problem, found.orbits.front().events));
  if (found.status != Status::done) console.err << "graze orbit: " << found.message << "\n";
  return deliver(result, options.output, "orbit", exit_code(found.status), console);
}

Json orbit_result_schema() {
  const Json orbit = with_quantities(schema_of(orbit_columns()));
  return result_schema("orbit/1", "a periodic orbit",
                       {object_schema({{"orbit", "null: there is none of the requested period", or_null(orbit)},
                                       {"orbits", "all that a search found, the orbit first", list_schema(orbit), false}}),
                        schema_of(origin_columns())});
}

std::function<int(const Console&)> set_up_orbit(CLI::App& app) {
  auto options = std::make_shared<OrbitArguments>();
  add_orbit_options(app, options->orbit);
  add_quantity_option(app, options->quantities);
  add_output_options(app, options->output, "orbit/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command orbit_command() {
  return {"orbit",
          "one periodic orbit, its multipliers, its contacts, its checks",
          "From --start the motion settles for --settle forcing periods, and Newton's method finds its orbit. If that orbit has\n"
          "another period than --period, or with --search, orbits are searched for in the whole state space, unstable ones\n"
          "included. If there is none of this period: exit 1, and the orbits found instead.",
          {"graze orbit data/problems/hertz-damped.toml --set eta=0.925",
           "graze orbit data/problems/hertz-damped.toml --set eta=0.85 --period 2 --search --json -"},
          set_up_orbit,
          {{"orbit", orbit_result_schema}}};
}

}  // namespace graze::apps
