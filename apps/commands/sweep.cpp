// SPDX-License-Identifier: GPL-3.0-or-later
// graze sweep: the attractor followed from value to value of a parameter, with its exponents: a bifurcation diagram.
#include <graze/apps/arguments.hpp>
#include <graze/apps/attractor_report.hpp>
#include <graze/apps/commands/command.hpp>
#include <graze/apps/find_orbit.hpp>
#include <graze/apps/input_file.hpp>
#include <graze/apps/interrupt.hpp>
#include <graze/apps/number.hpp>
#include <graze/apps/progress.hpp>
#include <graze/apps/result.hpp>

#include <graze/continuation/sweep.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct Options {
  StartOptions start;
  std::string parameter = "eta", direction = "up", resume;
  std::optional<double> from, to, step, standard_error;
  int transient = 300, periods = 20000, samples = 200;
  OutputOptions output;
};

SweepOptions sweep_options(const Options& options, const Problem& problem, const Console& console, Progress& progress) {
  SweepOptions out;
  out.parameter = options.parameter;
  out.from = *options.from;
  out.to = *options.to;
  out.step = *options.step;
  if (options.direction == "down") out.directions = {SweepDirection::down};
  if (options.direction == "both") out.directions = {SweepDirection::up, SweepDirection::down};
  out.first_transient = settle_of(problem, options.start);
  out.samples = options.samples;
  out.attractor.transient = options.transient;
  out.attractor.periods_on_orbit = 0;  // the multipliers say it all
  out.attractor.lyapunov.max_periods = options.periods;
  out.attractor.lyapunov.min_periods = std::min(options.periods, 500);
  out.attractor.lyapunov.standard_error = options.standard_error.value_or(1e-3);
  out.threads = console.thread_count();
  out.cancelled = interrupted;
  const double all = static_cast<double>(sweep_values(out.from, out.to, out.step).size() * out.directions.size());
  out.progress = [&progress, all, name = options.parameter](std::size_t rows, double value) {
    progress.update(static_cast<double>(rows) / all, [&] { return fmt::format("{} = {}", name, rounded(value, 7)); });
  };
  return out;
}

Json row_json(const SweepRow& row) {
  Json json = {{"value", row.value},
               {"direction", sweep_direction_name(row.direction)},
               {"attractor", attractor_json(row.attractor)},
               {"exponents", numbers_json(row.attractor.exponents)},
               {"standard_errors", numbers_json(row.attractor.standard_errors)},
               {"periods", row.attractor.time_average.periods},
               {"end", to_json(row.end)}};
  json["states"] = Json::array();
  for (const Vector& state : row.states) json["states"].push_back(to_json(state));
  json["impact_speeds"] = row.impact_speeds;
  return json;
}

SweepRow row_of(const Json& json) {
  SweepRow row;
  row.value = json.at("value");
  row.direction = json.at("direction") == "down" ? SweepDirection::down : SweepDirection::up;
  row.attractor = attractor_of(json.at("attractor"));
  row.attractor.exponents = numbers_of(json.at("exponents"));
  row.attractor.standard_errors = numbers_of(json.at("standard_errors"));
  row.attractor.time_average.periods = json.at("periods");
  row.end = vector_from(json.at("end"));
  for (const Json& state : json.at("states")) row.states.push_back(vector_from(state));
  row.impact_speeds = json.at("impact_speeds").get<std::vector<double>>();
  return row;
}

/// The rows of an earlier run, if it was one of the same options.
std::vector<SweepRow> earlier_rows(const Json& earlier, const std::string& folder, const Json& head) {
  check_same_run(earlier, head, folder);
  std::vector<SweepRow> rows;
  try {
    for (const Json& row : earlier.at("rows")) rows.push_back(row_of(row));
  } catch (const nlohmann::json::exception&) {
    refuse_to_resume(folder, "sweep", "is damaged; compute it anew");
  }
  return rows;
}

/// One line per stretch of rows with the same attractor.
Table overview(const std::vector<SweepRow>& rows, const std::string& parameter) {
  Table table{{"direction", parameter + " from", "to", "attractor", "values", "largest exponent from", "to"}, {}};
  for (std::size_t i = 0; i < rows.size();) {
    std::size_t end = i;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (; end < rows.size() && rows[end].direction == rows[i].direction &&
           attractor_name(rows[end].attractor) == attractor_name(rows[i].attractor);
         ++end) {
      if (rows[end].attractor.exponents.empty()) continue;
      low = std::min(low, rows[end].attractor.exponents[0]);
      high = std::max(high, rows[end].attractor.exponents[0]);
    }
    table.rows.push_back({std::string(sweep_direction_name(rows[i].direction)), rounded(rows[i].value, 7),
                          rounded(rows[end - 1].value, 7), attractor_name(rows[i].attractor), std::to_string(end - i),
                          rounded(low, 4), rounded(high, 4)});
    i = end;
  }
  return table;
}

Table samples_table(const std::vector<SweepRow>& rows, const std::string& parameter) {
  Table table{{parameter, "direction", "attractor", "period", "impacts", "exponent1", "exponent2", "x", "v"}, {}};
  for (const SweepRow& row : rows) {
    const Attractor& attractor = row.attractor;
    for (const Vector& state : row.states) {
      std::vector<std::string> cells = {exact(row.value), std::string(sweep_direction_name(row.direction)),
                                        std::string(attractor_type_name(attractor.type)),
                                        attractor.period > 0 ? std::to_string(attractor.period) : "",
                                        attractor.period > 0 ? std::to_string(attractor.impacts) : ""};
      for (std::size_t i = 0; i < 2; ++i) cells.push_back(i < attractor.exponents.size() ? exact(attractor.exponents[i]) : "");
      cells.push_back(exact(state[0]));
      cells.push_back(exact(state[1]));
      table.rows.push_back(std::move(cells));
    }
  }
  return table;
}

int run(const Options& given, const Console& console) {
  Options options = given;
  Json earlier;
  if (!options.resume.empty()) earlier = read_to_resume(options.resume, "sweep");
  if (!options.resume.empty() && options.output.out.empty()) options.output.out = options.resume;
  check_outputs(options.output, options.start.file);
  const Problem problem = open_problem(options.start, console);
  if (!(*options.from < *options.to))
    throw std::invalid_argument(fmt::format("--from {} and --to {}: a sweep needs from < to; --direction down goes the other way",
                                            exact(*options.from), exact(*options.to)));
  if (!(*options.step > 0.0)) throw std::invalid_argument(fmt::format("--step is {}; allowed is > 0", exact(*options.step)));
  if (options.standard_error && !(*options.standard_error > 0.0))
    throw std::invalid_argument(fmt::format("--standard-error is {}; allowed is > 0", exact(*options.standard_error)));
  Problem at_end = problem;  // a wrong value is found out now
  set_parameter(at_end, options.parameter, *options.from, "--from");
  set_parameter(at_end, options.parameter, *options.to, "--to");
  Json described = options_json(problem, options.start);
  described.update({{"param", options.parameter},
                    {"from", *options.from},
                    {"to", *options.to},
                    {"step", *options.step},
                    {"direction", options.direction},
                    {"transient", options.transient},
                    {"periods", options.periods},
                    {"samples", options.samples},
                    {"standard_error", options.standard_error.value_or(1e-3)}});
  Result result;
  result.json = result_head("sweep/1", "sweep", problem, described);
  result.json["parameter"] = options.parameter;
  std::vector<SweepRow> so_far;
  if (!options.resume.empty()) so_far = earlier_rows(earlier, options.resume, result.json);
  std::vector<SweepRow> rows;
  std::size_t expected = 0;
  {
    Progress progress(console.err, console.quiet, "sweeping");
    const SweepOptions sweeping = sweep_options(options, problem, console, progress);
    expected = sweep_values(sweeping.from, sweeping.to, sweeping.step).size() * sweeping.directions.size();
    rows = sweep(problem.system, problem.parameters, start_state(problem, options.start.start), sweeping, so_far);
  }
  Status status = Status::done;
  std::string message;
  if (interrupted()) {
    status = Status::interrupted;
    message = fmt::format("interrupted after {} of {} values", rows.size(), expected);
  } else if (rows.size() < expected) {
    status = Status::failed;
    message = fmt::format(
        "only {} of {} values could be reached: the motion could not be carried on, or the state left by one value lies "
        "inside the barrier of the next",
        rows.size(), expected);
  }
  set_status(result.json, status, message);
  result.json["rows"] = Json::array();
  for (const SweepRow& row : rows) result.json["rows"].push_back(row_json(row));
  result.table = samples_table(rows, options.parameter);
  result.text = describe(problem, options.parameter) + "\n\n" + aligned(overview(rows, options.parameter));
  if (status != Status::done) console.err << "graze sweep: " << message << "\n";
  return deliver(result, options.output, "sweep", exit_code(status), console);
}

std::function<int(const Console&)> setup(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_start_options(app, options->start);
  begin_group(app, "Sweep");
  add_text(app, "--param", options->parameter, "NAME", "parameter (default eta)");
  add_number(app, "--from", options->from, "lower end of its range", Need::required);
  add_number(app, "--to", options->to, "upper end", Need::required);
  add_number(app, "--step", options->step, "from one value to the next", Need::required);
  add_choice(app, "--direction", options->direction, {"up", "down", "both"}, "which way it goes (default up)");
  add_count(app, "--transient", options->transient, 0, "forcing periods of transient at each value but the first (default 300)");
  add_count(app, "--periods", options->periods, 1, "most forcing periods of each average (default 20000)");
  add_number(app, "--standard-error", options->standard_error, "bound of the exponents' standard errors (default 1e-3)");
  add_count(app, "--samples", options->samples, 1, "stroboscopic states kept of an attractor that is not periodic (default 200)");
  add_text(app, "--resume", options->resume, "DIR", "go on from the result that an interrupted run left in DIR (its --out)");
  add_output_options(app, options->output, "sweep/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command sweep_command() {
  return {"sweep",
          "the attractor followed from value to value of a parameter: bifurcation diagram and exponents",
          "Each value starts from the state in which the one before ended; up and down show hysteresis. Attractors are told "
          "apart as\n"
          "periodic (n, p), chaotic or undecided, with exponents; the table holds the stroboscopic states.",
          {"graze sweep data/problems/hertz-damped.toml --from 0.69 --to 0.75 --step 0.0005 --direction both --plot sweep.png",
           "graze sweep data/problems/newton-elastic.toml --from 0.7 --to 0.76 --step 0.001 --out run"},
          setup};
}

}  // namespace graze::apps
