// SPDX-License-Identifier: GPL-3.0-or-later
// graze poincare: points of a stroboscopic section, of impacts, or of named events.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/problem/ending.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/section_report.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <stdexcept>

namespace graze::apps {

namespace {

constexpr int noted_periods = 50;     // periods whose events are examined for notes
constexpr int most_points = 5000000;  // a result is held in memory before it is written

struct PoincareArguments {
  StartOptions start;
  std::string section;
  int points = 1000;
  std::vector<std::string> expressions;
  OutputOptions output;
};

/// Sets the requested section. In an autonomous system, an event given by name becomes the return.
void take_section(const PoincareArguments& options, Problem& problem, SectionOptions& collecting) {
  const bool forced = is_forced(problem.system);
  if (options.section == "impact") {
    collecting.kind = SectionKind::impact;
    return;
  }
  if (options.section == (forced ? "stroboscopic" : "returns") || options.section.empty()) {
    collecting.kind = forced ? SectionKind::stroboscopic : SectionKind::returns;
    return;
  }
  std::vector<std::string> names = {forced ? "stroboscopic" : "returns", "impact"};
  collecting.kind = forced ? SectionKind::event : SectionKind::returns;
  // The events of a stop with a force are "left enter" and "left leave": its own name means the first.
  const auto& events = problem.system.events;
  const auto is_event = [&](const std::string& name) {
    return std::any_of(events.begin(), events.end(), [&](const Event& event) { return event.name == name; });
  };
  const std::string entry = options.section + " enter";
  collecting.event = !is_event(options.section) && is_event(entry) ? entry : options.section;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const std::string& name = events[i].name;
    if (name == collecting.event) chosen.push_back(i);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  if (!forced) problem.system.returns = chosen;
  if (chosen.empty())
    throw std::invalid_argument(fmt::format("--section {}: must be one of {}", options.section, fmt::join(names, ", ")));
}

PoincareSection collect(const Problem& problem, const Vector& start, SectionOptions collecting, const PoincareArguments& options,
                        const Console& console) {
  Progress progress(console.err, console.quiet, "collecting");
  collecting.points = options.points;
  collecting.cancelled = interrupted;
  collecting.progress = [&](std::size_t points) {
    progress.update(static_cast<double>(points) / options.points,
                    [&] { return fmt::format("{} of {} points", points, options.points); });
  };
  return poincare_section(problem.system, problem.parameters, start, collecting);
}

/// Their values behind the columns of the section.
void append_values(const Quantities& expressions, const Problem& problem, PoincareSection& section) {
  if (section.kind != SectionKind::event) return append_values(expressions, problem, false, section.points);
  const auto states = static_cast<Eigen::Index>(problem.system.states);
  const double T = forcing_period(problem.system, problem.parameters);
  for (Vector& point : section.points) {
    std::vector<Vector> row(1, Vector(states + 1));
    row[0] << point[states] / (2.0 * std::numbers::pi) * T, point.head(states);
    append_values(expressions, problem, true, row);
    const Eigen::Index more = row[0].size() - states - 1;
    point.conservativeResize(point.size() + more);
    point.tail(more) = row[0].tail(more);
  }
}

int run(const PoincareArguments& options, const Console& console) {
  const OutputFolder folder(options.output, "poincare", options.start.file);
  Problem problem = open_problem(options.start, console);
  SectionOptions collecting;
  take_section(options, problem, collecting);
  const std::string name = options.section.empty() ? section_name(collecting.kind) : options.section;
  const Quantities expressions = read_expressions(problem, options.expressions);
  if (collecting.kind == SectionKind::impact && !expressions.empty())
    throw std::invalid_argument(fmt::format(
        "--y {}: an impact section has phases and speeds, no states; use --section stroboscopic", expressions.list.front().text));
  Json asked = options_json(problem, options.start);
  asked["section"] = name;
  asked["points"] = options.points;
  put_quantity_option(asked, options.expressions);
  Result result;
  result.json = result_head("poincare/1", "poincare", problem, asked);
  folder.check_free_for(result.json);
  const Settled settled = settle_down(problem, options.start, console);
  PoincareSection section;
  section.termination = settled.termination;
  section.state = settled.state;
  if (settled.termination == Termination::time) section = collect(problem, settled.state, collecting, options, console);

  Status status = Status::done;
  std::string message;
  if (section.termination != Termination::time) {
    status = section.termination == Termination::interrupted ? Status::interrupted : Status::failed;
    message = fmt::format("stopped after {}: {}", counted(section.points.size(), "point"),
                          ending_text(problem, section.termination, section.state));
  } else if (section.points.size() < static_cast<std::size_t>(options.points)) {
    status = Status::failed;
    message = fmt::format("stopped after {}: no {} in the last {} {}", counted(section.points.size(), "point"),
                          section.kind == SectionKind::event ? fmt::format("event {}", name) : "impact",
                          SectionOptions{}.patience, periods_name(problem));
  }
  set_status(result.json, status, message);
  append_values(expressions, problem, section);
  result.json.update(section_json(problem, section));
  for (const Quantity& one : expressions.list) result.json["columns"].push_back(one.text);
  result.table.columns = result.json["columns"].get<std::vector<std::string>>();
  for (const Vector& point : section.points) result.table.rows.push_back(table_cells(point));
  result.text = fmt::format("{}\n{} of the {} section in {}\n{}", describe(problem), counted(section.points.size(), "point"),
                            name, counted_periods(problem, section.periods), aligned(result.table));
  if (settled.termination == Termination::time)
    add_notes(result, order_notes(problem, settled.state, std::min(section.periods, noted_periods)));
  if (status != Status::done) console.err << "graze poincare: " << message << "\n";
  return deliver(result, options.output, "poincare", exit_code(status), console);
}

Json poincare_result_schema() {
  return result_schema("poincare/1", "points of a section", {schema_of(listed_section_columns())});
}

std::function<int(const Console&)> set_up_poincare(CLI::App& app) {
  auto options = std::make_shared<PoincareArguments>();
  add_start_options(app, options->start);
  begin_group(app, "Section");
  add_text(app, "--section", options->section, "NAME",
           "stroboscopic: states at forcing phase 0 (default); impact: phase and speed of each impact; an event by its name: "
           "states right behind it, and the phase; without forcing returns (default), impact, or an event");
  add_count(app, "--points", options->points, 1, "number of points, after the transient (default 1000)", most_points);
  add_texts(app, "--y", options->expressions, "EXPRESSION",
            "also record this expression of states and parameters, and draw it against the first state; repeatable");
  add_output_options(app, options->output, "poincare/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command poincare_command() {
  return {"poincare",
          "points of a stroboscopic or impact section",
          "After --settle forcing periods of transient, points of the section are collected: states at forcing phase 0, at "
          "each impact (entry\n"
          "into contact) the forcing phase and the speed of approach, or the states behind each event of one name.",
          {"graze poincare data/problems/newton-elastic.toml --set eta=0.711 --points 5000 --plot section.png",
           "graze poincare data/problems/beam-newton.toml --section impact --csv -"},
          set_up_poincare,
          {{"poincare", poincare_result_schema}}};
}

}  // namespace graze::apps
