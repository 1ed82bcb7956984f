// SPDX-License-Identifier: GPL-3.0-or-later
// graze lyapunov: the spectrum of exponents on the attractor that the motion reaches.
#include <graze/apps/commands/command.hpp>
#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/output/notes.hpp>
#include <graze/apps/output/output_folder.hpp>
#include <graze/apps/output/result.hpp>
#include <graze/apps/problem/ending.hpp>
#include <graze/apps/problem/flow_choice.hpp>
#include <graze/apps/results/attractor_report.hpp>
#include <graze/apps/results/find_orbit.hpp>
#include <graze/apps/results/orbit_report.hpp>
#include <graze/apps/text/number.hpp>

#include <graze/floquet/attractor/attractor.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

namespace graze::apps {

namespace {

struct LyapunovArguments {
  StartOptions start;
  int periods = 200000, interval = 1, max_period = 64;
  std::optional<double> standard_error, change;
  FlowChoice flow;
  std::vector<std::string> quantities;
  OutputOptions output;
};

AttractorOptions attractor_options(const LyapunovArguments& options, const Problem& problem, Progress& progress) {
  AttractorOptions out;
  out.transient = settle_of(problem, options.start);
  out.max_period = options.max_period;
  out.lyapunov.interval = options.interval;
  out.lyapunov.max_periods = options.periods;
  if (options.standard_error) out.lyapunov.standard_error = *options.standard_error;
  if (options.change) out.lyapunov.change = *options.change;
  out.lyapunov.all_threads = true;
  out.lyapunov.flow.kind = options.flow.kind();
  out.lyapunov.cancelled = interrupted;
  out.lyapunov.progress = [&progress, &problem, most = options.periods](std::int64_t periods) {
    progress.update(static_cast<double>(periods) / most, [&] { return fmt::format("{} {}", periods, periods_name(problem)); });
  };
  return out;
}

const Columns<Attractor>& result_columns() {
  using A = Attractor;
  const auto is_orbit = [](const A& attractor) { return attractor.type == AttractorType::periodic; };
  static const Columns<A> list =
      joined<A>({exponents_columns(),
                 {{"converged", "the errors are below their bounds",
                   [=](const A& attractor) { return is_orbit(attractor) || attractor.time_average.converged(); }}},
                 {{"periods", "of the time average", [](const A& attractor) { return attractor.time_average.periods; }},
                  {"liouville_residual", "of the time average; null: not applicable",
                   [](const A& attractor) { return liouville_residual(attractor.time_average); }},
                  {"kaplan_yorke", "dimension", [](const A& attractor) { return kaplan_yorke_dimension(attractor.exponents); }},
                  {"stop", "why the average ended",
                   [=](const A& attractor) {
                     return std::string(is_orbit(attractor) ? "the attractor is a stable orbit"
                                                            : lyapunov_stop_text(attractor.time_average));
                   }},
                  {"attractor", "attractor of the motion", [](const A& attractor) { return attractor; }},
                  {"time_average", "along the motion, on an orbit too", &A::time_average}}});
  return list;
}

int run(const LyapunovArguments& options, const Console& console) {
  const OutputFolder folder(options.output, "lyapunov", options.start.file);
  for (const auto& [name, value] : {std::pair{"--standard-error", options.standard_error}, {"--change", options.change}})
    if (value && !(*value >= 0.0)) throw std::invalid_argument(fmt::format("{} is {}; allowed is >= 0", name, exact(*value)));
  if (options.change && options.standard_error)
    throw std::invalid_argument("--change and --standard-error are two ways to end the average; give one of them");
  if (options.periods < options.interval)
    throw std::invalid_argument(
        fmt::format("--periods {} is less than --interval {}; give at least one interval", options.periods, options.interval));
  const Problem problem = open_problem(options.start, console);
  const Quantities quantities = read_quantities(problem, options.quantities);
  const Vector start = start_state(problem, options.start);
  Json given = options_json(problem, options.start);
  given.update({{"periods", options.periods}, {"interval", options.interval}, {"max_period", options.max_period}});
  if (options.standard_error) given["standard_error"] = *options.standard_error;
  if (options.change) given["change"] = *options.change;
  put_quantity_option(given, options.quantities);
  put_flow(given, options.flow.kind());
  Result result;
  result.json = result_head("lyapunov/1", "lyapunov", problem, given);
  folder.check_free_for(result.json);
  Attractor attractor;
  {
    Progress progress(console.err, console.quiet, "averaging");
    attractor = find_attractor(problem.system, problem.parameters, start, attractor_options(options, problem, progress));
  }
  Status status = Status::done;
  std::string message;
  if (interrupted()) {
    // An average over the periods that the time limit allowed is a result, like one limited by --periods.
    const bool averaged = is_out_of_time() && !attractor.exponents.empty();
    status = averaged ? Status::done : Status::interrupted;
    message = fmt::format("{} after {} {} of averaging", interruption(), attractor.time_average.periods, periods_name(problem));
    if (averaged) console.note(message);
  } else if (attractor.termination != Termination::time || attractor.time_average.stop == LyapunovStop::failed) {
    status = Status::failed;
    const Termination ended =
        attractor.termination != Termination::time ? attractor.termination : attractor.time_average.termination;
    const bool is_told = ended == Termination::escape || ended == Termination::resonance || ended == Termination::no_return;
    message = fmt::format("{}{}", is_told || ended == Termination::grazing ? "" : "the motion could not be carried on: ",
                          ending_text(problem, ended, attractor.state));
  } else if (attractor.type != AttractorType::periodic && attractor.time_average.stop == LyapunovStop::budget &&
             options.standard_error != 0.0) {
    // Not a failure, and no other exit code: an average over this number of periods, with its error, is a result. A note says
    // so.
    message =
        fmt::format("the budget of {} {} is used up before {}; --periods gives more", options.periods, periods_name(problem),
                    options.change ? "the exponents have settled to --change" : "every standard error is below its bound");
    console.note(message);
  }
  set_status(result.json, status, message);
  result.json.update(json_of(result_columns(), attractor));
  QuantityValues measured;
  if (!attractor.exponents.empty()) measured = measure(quantities, problem.system, problem.parameters, attractor);
  put_quantities(result.json, measured);
  result.table = {{"exponent", "value", "standard_error", "time_average", "time_average_error"}, {}};
  for (std::size_t i = 0; i < attractor.exponents.size(); ++i) {
    const LyapunovSpectrum& mean = attractor.time_average;
    const bool there = i < mean.exponents.size();
    result.table.rows.push_back({std::to_string(i + 1), exact(attractor.exponents[i]), exact(attractor.standard_errors[i]),
                                 there ? exact(mean.exponents[i]) : "", there ? exact(mean.standard_errors[i]) : ""});
  }
  result.text = describe(problem) + "\n\n" +
                (attractor.exponents.empty() ? message + "\n" : attractor_text(problem, attractor, options.max_period)) +
                quantities_text(measured);
  if (status == Status::done && interrupted()) result.text += "\n" + message + "\n";
  add_notes(result, order_notes(problem, attractor.state, std::max(1, attractor.period)));
  if (status != Status::done) console.err << "graze lyapunov: " << message << "\n";
  return deliver(result, options.output, "lyapunov", exit_code(status), console);
}

Json lyapunov_result_schema() {
  return result_schema("lyapunov/1", "the exponents on an attractor", {with_quantities(schema_of(result_columns()))});
}

std::function<int(const Console&)> set_up_lyapunov(CLI::App& app) {
  auto options = std::make_shared<LyapunovArguments>();
  add_start_options(app, options->start);
  begin_group(app, "Average");
  add_count(app, "--periods", options->periods, 1,
            "most forcing periods (returns without forcing) of the average (default 200000)");
  add_number(app, "--standard-error", options->standard_error, "stop where every standard error is below this (default 3e-4)");
  add_count(app, "--interval", options->interval, 1,
            "forcing periods (returns without forcing) between two orthonormalisations (default 1)");
  add_number(app, "--change", options->change,
             "stop where no exponent changes by more than this from one interval to the next, instead of --standard-error");
  add_count(app, "--max-period", options->max_period, 1, "longest period that is recognised (default 64)");
  add_flow_option(app, options->flow);
  add_quantity_option(app, options->quantities);
  add_output_options(app, options->output, "lyapunov/1");
  return [options](const Console& console) { return run(*options, console); };
}

}  // namespace

Command lyapunov_command() {
  return {
      "lyapunov",
      "the spectrum of Lyapunov exponents, with standard errors, on the attractor reached",
      "From --start the motion settles for --settle forcing periods. If it is settling on a stable orbit, the exponents are\n"
      "those of its multipliers, and the time average is given beside them. Else they are averaged until every standard error\n"
      "(batch means) is below its bound, or the budget is used up (exit code 0 too, with a note; in JSON \"converged\" is false\n"
      "then, and \"message\" says why). The sum is checked by Liouville's identity.",
      {"graze lyapunov data/problems/hertz-damped.toml --set eta=0.72",
       "graze lyapunov data/problems/newton-elastic.toml --set eta=0.711 --standard-error 1e-4 --json -"},
      set_up_lyapunov,
      {{"lyapunov", lyapunov_result_schema}}};
}

}  // namespace graze::apps
