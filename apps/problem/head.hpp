// SPDX-License-Identifier: GPL-3.0-or-later
// The head with which every result begins, and from which it can be recomputed:
//     "schema", "graze", "command", "model", "parameters", "options", and "status" ("done", "failed", "interrupted") with
//     "message".
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/text/json.hpp>

#include <string>

namespace graze::apps {

/// `schema` is "orbit/1" and the like.
Json result_head(const std::string& schema, const std::string& command, const Problem& problem, Json options);

/// The schema of a result that begins with a head, and has these members behind it.
Json result_schema(const std::string& schema, const std::string& meaning, const std::vector<Json>& members);
/// The same of one that is not of a problem.
Json plain_result_schema(const std::string& schema, const std::string& meaning, const std::vector<Json>& members);

/// How a command ended, as it stands in its result.
enum class Status { done, failed, interrupted };
const char* status_name(Status status);
void set_status(Json& result, Status status, const std::string& message = {});
/// 0, 1 or 130; 1 where --time has interrupted it.
int exit_code(Status status);

/// Model and parameters of a result's head. @throws std::invalid_argument naming what is missing.
Problem problem_of(const Json& result);

}  // namespace graze::apps
