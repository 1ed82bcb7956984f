// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by `graze sweep` and `graze diagram`: the options that control how attractors are followed, and the run itself with
// its progress and its ending.
#pragma once

#include <graze/apps/console/arguments.hpp>
#include <graze/apps/console/console.hpp>
#include <graze/apps/problem/flow_choice.hpp>
#include <graze/apps/results/find_orbit.hpp>

#include <graze/floquet/follow/sweep.hpp>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

struct SweepingOptions {
  std::optional<double> step, standard_error;
  int transient = 300, periods = 20000, samples = 200;
  int max_period = 256;  ///< longest period that is recognised
  FlowChoice flow;
};

/// Adds --step (with `step_help`), --transient, --periods, --standard-error, --samples, --flow.
void add_sweeping_options(CLI::App& app, SweepingOptions& options, Need step, const std::string& step_help);

/// @throws std::invalid_argument for a step or a standard error that is not > 0.
void check_sweeping(const SweepingOptions& options);

/// Checks --from and --to against the parameter's range. `reversible`: they may be given in either order.
/// @throws std::invalid_argument also for an empty range.
void check_range(const Problem& problem, const std::string& parameter, double from, double to, bool reversible);

/// The options as they are written in a result; the step must be set.
Json sweeping_json(const SweepingOptions& options);

struct SweepRange {
  std::string parameter;
  double from = 0.0, to = 0.0;  ///< from < to
  std::vector<SweepDirection> directions = {SweepDirection::up};
};

/// @throws std::invalid_argument if the motion cannot begin at the first value of a direction.
void check_sweep_start(const Problem& problem, const StartOptions& start, const SweepRange& range);

struct SweepOutcome {
  std::vector<SweepRow> rows;
  Status status = Status::failed;
  std::string message;  ///< why some values were not reached
};

/// Checkpoints: `keep` receives the rows finished so far, every `checkpoints` seconds (checkpoint_timer.hpp); nullopt: no
/// checkpoints.
struct RowCheckpoints {
  std::optional<double> checkpoints;
  std::function<void(const SweepOutcome&)> keep;
};

/// Runs the sweeps, with progress on the console. Ctrl-C ends them and keeps the finished rows. `so_far`: rows of an earlier
/// run.
SweepOutcome carry_out_sweeps(const Problem& problem, const StartOptions& start, const SweepRange& range,
                              const SweepingOptions& options, const Console& console, const std::vector<SweepRow>& so_far,
                              const RowCheckpoints& keeping);

}  // namespace graze::apps
