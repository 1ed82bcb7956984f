// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the program on random cases and counts the checker's complaints.
#pragma once

#include "checker.hpp"

#include <iosfwd>
#include <map>

namespace graze::reference {

struct Plan {
  std::uint64_t seed = 1;
  std::uint64_t first = 0, cases = 100;
  bool skeletons = false;           ///< of `diagram --skeleton`, not of `continue`
  std::optional<std::size_t> name;  ///< of the parameter that changes; else any
  Model model = Model::barrier;
  std::string program, data, systems;  ///< paths of graze, and of the folders with newton-elastic.toml and the other models
  int most_impacts = 16;               ///< of families that are compared: their equations take long in Quad
  double limit = 0.0;                  ///< --time of one command, after which what there is is checked; 0: none
  double patience = 20.0;              ///< seconds for one command
  double time = 1e9;                   ///< seconds for all: then the rest is not run
};

struct Summary {
  std::uint64_t cases = 0, undecided = 0, failed = 0, families = 0, unresolved = 0;
  std::map<std::string, std::uint64_t> kinds;  ///< cases in which a kind of complaint appears
};

/// The answer to a command and its arguments, in a process of its own.
Answer answered(const Plan& plan, const std::string& command, const std::string& arguments);

/// Writes one line for each case that fails: number, complaints, command.
Summary run(const Plan& plan, std::ostream& out);

}  // namespace graze::reference
