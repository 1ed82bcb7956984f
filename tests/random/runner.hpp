// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the program on random cases and counts the complaints of the checker.
#pragma once

#include "checker.hpp"

#include <iosfwd>
#include <map>

namespace graze::reference {

struct Plan {
  std::uint64_t seed = 1;
  std::uint64_t first = 0, cases = 100;
  bool skeletons = false;           ///< of `diagram --skeleton`, not of `continue`
  std::optional<std::size_t> name;  ///< the parameter that changes; empty: any
  Model model = Model::barrier;
  std::string program, data, systems;  ///< paths of graze, and of the folders with newton-elastic.toml and the other models
  int most_impacts = 16;               ///< of compared families: their equations are slow in Quad
  double limit = 0.0;                  ///< --time of one command; the partial result is checked; 0: none
  double patience = 20.0;              ///< seconds for one command
  double time = 1e9;                   ///< seconds for all: the rest is not run
};

struct Summary {
  std::uint64_t cases = 0, undecided = 0, failed = 0, families = 0, unresolved = 0;
  std::map<std::string, std::uint64_t> kinds;  ///< number of cases with each kind of complaint
};

/// The answer to a command and its arguments, from a separate process.
Answer answered(const Plan& plan, const std::string& command, const std::string& arguments);

/// Writes one line for each case that fails: number, complaints, command.
Summary run(const Plan& plan, std::ostream& out);

}  // namespace graze::reference
