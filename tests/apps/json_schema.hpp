// SPDX-License-Identifier: GPL-3.0-or-later
// Checks results against the schemas that `graze schema` prints.
#pragma once

#include "graze_program.hpp"

#include <graze/apps/text/json.hpp>

#include <string>
#include <vector>

namespace graze::support {

/// One sentence for each place where the value violates the schema. Supports the keywords that our schemas use, and throws for
/// any other.
std::vector<std::string> schema_faults(const apps::Json& value, const apps::Json& schema, const std::string& place = "$");

/// The faults of a result, by the schema that it names.
std::vector<std::string> result_faults(const apps::Json& result);

/// Fails the test if a result of the run, on stdout or in a file, violates its schema. A refused run has no result.
void check_results(const std::vector<std::string>& arguments, const Outcome& outcome);

}  // namespace graze::support
