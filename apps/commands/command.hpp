// SPDX-License-Identifier: GPL-3.0-or-later
// Command: one task of the program. A file in this folder holds a struct of its arguments, `run(arguments, console)` and a
// function that describes the command; commands.cpp lists it. Help is printed from the list.
#pragma once

#include <graze/apps/console/console.hpp>
#include <graze/apps/text/json.hpp>

#include <functional>
#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming)
class App;
}

namespace graze::apps {

/// A kind of result that a command writes.
struct ResultKind {
  std::string name;  ///< "orbit" in "graze.orbit/1"
  Json (*schema)() = nullptr;
};

struct Command {
  std::string name;
  std::string summary;  ///< one line, for the list
  std::string details;  ///< a paragraph, for the command's own help
  std::vector<std::string> examples;
  /// Adds the options to the subcommand and returns the function that runs it. That function returns the exit code; misuse
  /// throws std::invalid_argument.
  std::function<int(const Console&)> (*setup)(CLI::App& app) = nullptr;
  std::vector<ResultKind> results = {};
};

/// All commands, in the order in which they are listed to users.
const std::vector<Command>& commands();
/// Adds one from outside the library; see run_main (program.hpp). @throws std::invalid_argument if there is one of this name.
void add_command(Command command);

Command models_command();
Command orbit_command();
Command continue_command();
Command locate_command();
Command diagram_command();
Command lyapunov_command();
Command sweep_command();
Command attractors_command();
Command map_command();
Command verify_command();
Command reproduce_command();
Command trajectory_command();
Command poincare_command();
Command plot_command();
Command schema_command();

}  // namespace graze::apps
