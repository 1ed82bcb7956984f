// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeping: what `graze sweep` and `graze diagram` share: the options that say how attractors are followed, and the run itself
// with its progress and its ending.
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

/// --step (with `step_help`), --transient, --periods, --standard-error, --samples, --flow.
void add_sweeping_options(CLI::App& app, SweepingOptions& options, Need step, const std::string& step_help);

/// @throws std::invalid_argument for a step or a standard error that is not > 0.
void check_sweeping(const SweepingOptions& options);

/// As they stand in a result; the step is given by then.
Json sweeping_json(const SweepingOptions& options);

struct SweepRange {
  std::string parameter;
  double from = 0.0, to = 0.0;  ///< from < to
  std::vector<SweepDirection> directions = {SweepDirection::up};
};

/// @throws std::invalid_argument if the motion cannot begin at the first value of a direction.
void check_sweep_start(const Problem& problem, const StartOptions& start, const SweepRange& range);

struct Swept {
  std::vector<SweepRow> rows;
  Status status = Status::failed;
  std::string message;  ///< why not all values were reached
};

/// What is told of the rows that are there after each stint (stints.hpp) of so many seconds; without them, of none.
struct KeepingRows {
  std::optional<double> stints;
  std::function<void(const Swept&)> keep;
};

/// The sweeps, with progress on the console; Ctrl-C ends them with what is there. `so_far`: rows that are there already.
Swept carry_out_sweeps(const Problem& problem, const StartOptions& start, const SweepRange& range, const SweepingOptions& options,
                       const Console& console, const std::vector<SweepRow>& so_far, const KeepingRows& keeping);

}  // namespace graze::apps
