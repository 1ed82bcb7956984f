// SPDX-License-Identifier: GPL-3.0-or-later
// The head of every result, from which the result can be recomputed:
//     "schema", "graze", "command", "model", "parameters", "options", and "status" ("done", "failed", "interrupted") with
//     "message".
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/text/json.hpp>

#include <string>

namespace graze::apps {

/// `schema` is "orbit/1" and the like.
Json result_head(const std::string& schema, const std::string& command, const Problem& problem, Json options);

/// The schema of a result with a head, followed by these members.
Json result_schema(const std::string& schema, const std::string& meaning, const std::vector<Json>& members);
/// The same for a result that does not belong to a problem.
Json plain_result_schema(const std::string& schema, const std::string& meaning, const std::vector<Json>& members);

/// How a command ended, as written in its result.
enum class Status { done, failed, interrupted };
const char* status_name(Status status);
void set_status(Json& result, Status status, const std::string& message = {});
/// 0, 1 or 130; 1 if --time interrupted the command.
int exit_code(Status status);

/// Model and parameters from a result's head. @throws std::invalid_argument naming the missing entry.
Problem problem_of(const Json& result);

}  // namespace graze::apps
