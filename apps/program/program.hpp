// SPDX-License-Identifier: GPL-3.0-or-later
// The program as a function. Exit codes: 0 done; 1 a numerical stop before the requested result; 2 misuse, or an output that
// cannot be written; 130 interrupted.
#pragma once

#include <ostream>
#include <string>
#include <vector>

namespace graze::apps {

/// Runs the program with these arguments (without its own name).
int run_program(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace graze::apps
