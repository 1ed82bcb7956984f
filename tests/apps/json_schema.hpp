// SPDX-License-Identifier: GPL-3.0-or-later
// Results held against the schemas that `graze schema` prints.
#pragma once

#include "graze_program.hpp"

#include <graze/apps/text/json.hpp>

#include <string>
#include <vector>

namespace graze::support {

/// A sentence on each place of a value that is not as the schema says. Knows the keywords that our schemas use, and throws on any
/// other.
std::vector<std::string> schema_faults(const apps::Json& value, const apps::Json& schema, const std::string& place = "$");

/// Of a result, by the schema that it names.
std::vector<std::string> result_faults(const apps::Json& result);

/// Fails the test where a result that a run of the program has left on stdout or in a file is not as its schema says. One that
/// was refused has left none.
void check_results(const std::vector<std::string>& arguments, const Outcome& outcome);

}  // namespace graze::support
