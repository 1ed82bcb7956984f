// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the orbit of a command. Every command keeps this order: --set, then --from, then --start, --settle, then Newton; if the
// attractor reached does not have the requested period, a search.
#pragma once

#include <graze/apps/console/console.hpp>
#include <graze/apps/problem/head.hpp>
#include <graze/apps/problem/problem.hpp>
#include <graze/apps/text/column.hpp>

#include <graze/floquet/attractor/find_orbit.hpp>

#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace graze::apps {

/// Options that select the problem and the start.
struct StartOptions {
  std::string file;
  std::vector<std::string> settings;
  std::optional<StateText> start;
  std::optional<int> settle;
};

/// Options that select the orbit.
struct OrbitOptions {
  StartOptions start;
  std::optional<int> period;
  bool search = false;
  int seed = 1;
};

/// Adds PROBLEM and --set.
void add_problem_options(CLI::App& app, StartOptions& options);
/// Adds these and --start, --settle.
void add_start_options(CLI::App& app, StartOptions& options);
void add_orbit_options(CLI::App& app, OrbitOptions& options);

/// The problem with its settings applied; notes on defaults and on the conversion of units go to the console. Physical
/// quantities among `varied`, names given by --param, become parameters.
Problem open_problem(const StartOptions& options, const Console& console, const std::vector<std::string>& varied = {});

/// --start, else the file's state, else rest. @throws std::invalid_argument, see start_state.
Vector start_state(const Problem& problem, const StartOptions& options);

int settle_of(const Problem& problem, const StartOptions& options);
int period_of(const Problem& problem, const OrbitOptions& options);

/// The options as they are written in a result.
Json options_json(const Problem& problem, const StartOptions& options);
Json options_json(const Problem& problem, const OrbitOptions& options);

/// The state after the transient, with progress on the console.
Settled settle_down(const Problem& problem, const StartOptions& options, const Console& console);

struct OrbitResult : FoundOrbits {
  Status status = Status::failed;
  std::string message;  ///< why no orbit was found, and the orbits found instead
  std::string remark;   ///< the attractor reached, if a search had to follow
};

/// Orbits at the parameters of the problem; each returned orbit carries finite-difference checks.
OrbitResult find_orbits(const Problem& problem, const OrbitOptions& options, const Console& console);

/// The same, by the global search only.
OrbitResult search_for_orbits(const Problem& problem, const OrbitOptions& options, const Console& console);

/// The part of the search that every result holds: origin, and the settled state.
const Columns<OrbitResult>& origin_columns();

}  // namespace graze::apps
