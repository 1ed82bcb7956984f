// SPDX-License-Identifier: GPL-3.0-or-later
// The program as a function. Exit codes: 0 done; 1 a numerical stop before the requested result; 2 misuse, or an output that
// cannot be written; 130 interrupted.
#pragma once

#include <graze/apps/commands/command.hpp>
#include <graze/apps/pictures/pictures.hpp>

#include <ostream>
#include <string>
#include <vector>

namespace graze::apps {

/// Additions of a program of one's own: commands, and kinds of pictures for their results.
struct Additions {
  std::vector<Command> commands = {};
  std::vector<PictureKind> pictures = {};
};

/// The program's main function: watches signals, prints on the standard streams (under mpirun only in one process), and returns
/// the exit code. Call it once.
int run_main(int argc, char** argv, const Additions& additions = {});

/// Runs the program with these arguments (without its own name).
int run_program(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace graze::apps
