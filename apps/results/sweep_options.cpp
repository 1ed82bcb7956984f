// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/console/checkpoint_timer.hpp>
#include <graze/apps/console/interrupt.hpp>
#include <graze/apps/console/progress.hpp>
#include <graze/apps/results/sweep_options.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace graze::apps {

namespace {

double standard_error_of(const SweepingOptions& options) { return options.standard_error.value_or(1e-3); }

SweepOptions sweep_options(const SweepRange& range, const SweepingOptions& options) {
  SweepOptions out;
  out.parameter = range.parameter;
  out.from = range.from;
  out.to = range.to;
  out.step = *options.step;
  out.directions = range.directions;
  out.samples = options.samples;
  out.attractor.transient = options.transient;
  out.attractor.max_period = options.max_period;
  out.attractor.periods_on_orbit = 0;  // the multipliers are sufficient
  out.attractor.lyapunov.max_periods = options.periods;
  out.attractor.lyapunov.min_periods = std::min(options.periods, 500);
  out.attractor.lyapunov.standard_error = standard_error_of(options);
  out.attractor.lyapunov.flow.kind = options.flow.kind();
  return out;
}

}  // namespace

void add_sweeping_options(CLI::App& app, SweepingOptions& options, Need step, const std::string& step_help) {
  add_number(app, "--step", options.step, step_help, step);
  add_count(app, "--transient", options.transient, 0,
            "most forcing periods (returns without forcing) of transient at each value but the first (default 300); a stable "
            "orbit that is proved ends it");
  add_count(app, "--periods", options.periods, 1,
            "most forcing periods (returns without forcing) of each average (default 20000)");
  add_number(app, "--standard-error", options.standard_error, "bound of the exponents' standard errors (default 1e-3)");
  add_count(app, "--samples", options.samples, 1, "stroboscopic states kept of an attractor that is not periodic (default 200)");
  add_flow_option(app, options.flow);
}

void check_sweeping(const SweepingOptions& options) {
  if (options.step && !(*options.step > 0.0))
    throw std::invalid_argument(fmt::format("--step is {}; allowed is > 0", exact(*options.step)));
  if (options.standard_error && !(*options.standard_error > 0.0))
    throw std::invalid_argument(fmt::format("--standard-error is {}; allowed is > 0", exact(*options.standard_error)));
}

void check_range(const Problem& problem, const std::string& parameter, double from, double to, bool reversible) {
  Problem at_end = problem;
  set_parameter(at_end, parameter, from, "--from");
  set_parameter(at_end, parameter, to, "--to");
  if (from < to || (reversible && from > to)) return;
  throw std::invalid_argument(fmt::format("--from {} and --to {}: the range is empty; {}", exact(from), exact(to),
                                          reversible ? "they must differ" : "--from must be below --to, in both directions"));
}

Json sweeping_json(const SweepingOptions& options) {
  Json json = {{"step", *options.step},
               {"transient", options.transient},
               {"periods", options.periods},
               {"samples", options.samples},
               {"standard_error", standard_error_of(options)}};
  put_flow(json, options.flow.kind());
  return json;
}

namespace {

/// The start of a sweep. If no start is given: rest in front of the barrier at the first value of every direction.
Vector sweep_start(const Problem& problem, const StartOptions& start, const SweepRange& range) {
  Vector state = start_state(problem, start);
  if (start.start || problem.start) return state;
  for (const SweepDirection direction : range.directions) {
    Problem first = problem;
    set_parameter(first, range.parameter, direction == SweepDirection::up ? range.from : range.to);
    state = state.cwiseMin(rest_state(first, first.parameters));
  }
  return state;
}

}  // namespace

void check_sweep_start(const Problem& problem, const StartOptions& start, const SweepRange& range) {
  const Vector state = sweep_start(problem, start, range);
  for (const SweepDirection direction : range.directions) {
    Problem first = problem;
    set_parameter(first, range.parameter, direction == SweepDirection::up ? range.from : range.to);
    start_state(first, state);
  }
}

SweepOutcome carry_out_sweeps(const Problem& problem, const StartOptions& start, const SweepRange& range,
                              const SweepingOptions& options, const Console& console, const std::vector<SweepRow>& so_far,
                              const RowCheckpoints& keeping) {
  Progress progress(console.err, console.quiet, "sweeping");
  SweepOptions sweeping = sweep_options(range, options);
  sweeping.first_transient = settle_of(problem, start);
  sweeping.threads = console.thread_count();
  const std::size_t expected = sweep_values(range.from, range.to, sweeping.step).size() * range.directions.size();
  sweeping.progress = [&](std::size_t rows, double value) {
    progress.update(static_cast<double>(rows) / static_cast<double>(expected),
                    [&] { return fmt::format("{} = {}", range.parameter, rounded(value, 7)); });
  };
  sweeping.cancelled = interrupted;
  CheckpointTimer checkpoints(keeping.checkpoints, CheckpointTimer::End::goes_on);
  sweeping.keep = [&](const std::function<std::vector<SweepRow>()>& rows) {
    checkpoints.news();
    if (!checkpoints.over()) return;
    SweepOutcome part{rows(), Status::interrupted, {}};
    part.message = fmt::format("kept after {} of {} values, while it went on", part.rows.size(), expected);
    keeping.keep(part);
    checkpoints.begin(part.rows.size());
  };
  checkpoints.begin(so_far.size());
  SweepOutcome out{{}, Status::done, {}};
  out.rows = sweep(problem.system, problem.parameters, sweep_start(problem, start, range), sweeping, so_far);
  if (interrupted() && out.rows.size() < expected) {
    out.status = Status::interrupted;
    out.message = fmt::format("{} after {} of {} values", interruption(), out.rows.size(), expected);
  } else if (out.rows.size() < expected) {
    out.status = Status::failed;
    out.message = fmt::format(
        "only {} of {} values could be reached: the motion could not be carried on, or the state left by one value lies "
        "inside the barrier of the next",
        out.rows.size(), expected);
  }
  return out;
}

}  // namespace graze::apps
