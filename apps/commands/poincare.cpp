// SPDX-License-Identifier: GPL-3.0-or-later
// graze poincare: points of a stroboscopic section or of the impacts.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/problem/section.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <memory>

namespace graze::apps {

namespace {

constexpr int most_points = 5000000;  // a result is held in memory before it is written

struct Options {
  StartOptions start;
  std::string section = "stroboscopic";
  int points = 1000;
  OutputOptions output;
};

Section collect(const Problem& problem, const Vector& start, const Options& options, const Console& console) {
  Progress progress(console.err, console.quiet, "collecting");
  SectionOptions collecting;
  collecting.kind = options.section == "impact" ? SectionKind::impact : SectionKind::stroboscopic;
  collecting.points = options.points;
  collecting.cancelled = interrupted;
  collecting.progress = [&](std::size_t points) {
    progress.update(static_cast<double>(points) / options.points,
                    [&] { return fmt::format("{} of {} points", points, options.points); });
  };
  return collect_section(problem, start, collecting);
}

int run(const Options& options, const Console& console) {
  const OutputFolder folder(options.output, "poincare", options.start.file);
  const Problem problem = open_problem(options.start, console);
  Json asked = options_json(problem, options.start);
  asked["section"] = options.section;
  asked["points"] = options.points;
  Result result;
  result.json = result_head("poincare/1", "poincare", problem, asked);
  folder.check_free_for(result.json);
  const Settled settled = settle_down(problem, options.start, console);
  Section section;
  section.termination = settled.termination;
  if (settled.termination == Termination::time) section = collect(problem, settled.state, options, console);

  Status status = Status::done;
  std::string message;
  if (section.termination != Termination::time) {
    status = section.termination == Termination::interrupted ? Status::interrupted : Status::failed;
    message = fmt::format("stopped after {}: {}", counted(section.points.size(), "point"), termination_text(section.termination));
  } else if (section.points.size() < static_cast<std::size_t>(options.points)) {
    status = Status::failed;
    message = fmt::format("stopped after {}: no impact in the last {} forcing periods", counted(section.points.size(), "point"),
                          patience);
  }
  set_status(result.json, status, message);
  result.json.update(section_json(problem, section));
  result.table.columns = result.json["columns"].get<std::vector<std::string>>();
  for (const Vector& point : section.points) result.table.rows.push_back(exact_cells(point));
  result.text =
      fmt::format("{}\n{} of the {} section in {}\n{}", describe(problem), counted(section.points.size(), "point"),
                  options.section, counted(static_cast<std::size_t>(section.periods), "forcing period"), aligned(result.table));
  if (status != Status::done) console.err << "graze poincare: " << message << "\n";
  return deliver(result, options.output, "poincare", exit_code(status), console);
}

std::function<int(const Console&)> setup(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_start_options(app, options->start);
  begin_group(app, "Section");
  add_choice(app, "--section", options->section, {"stroboscopic", "impact"},
             "states at forcing phase 0, or phase and speed of each impact (default stroboscopic)");
  add_count(app, "--points", options->points, 1, "number of points, after the transient (default 1000)", most_points);
  add_output_options(app, options->output, "poincare/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command poincare_command() {
  return {"poincare",
          "points of a stroboscopic or impact section",
          "After --settle forcing periods of transient, points of the section are collected: states at forcing phase 0, or at "
          "each impact (entry\n"
          "into contact) the forcing phase and the speed of approach.",
          {"graze poincare data/problems/newton-elastic.toml --set eta=0.711 --points 5000 --plot section.png",
           "graze poincare data/problems/beam-newton.toml --section impact --csv -"},
          setup};
}

}  // namespace graze::apps
