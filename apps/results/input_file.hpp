// SPDX-License-Identifier: GPL-3.0-or-later
// Reading results back: whole files, and JSON from their text.
#pragma once

#include <graze/apps/text/json.hpp>

#include <string>

namespace graze::apps {

/// The content of a result file, which must be a regular file. @throws std::invalid_argument in one sentence that names the
/// file.
std::string read_whole(const std::string& file);

/// @throws std::invalid_argument with the place of the damage.
Json parse_json(const std::string& text);

/// @throws std::invalid_argument if the folder given by --resume holds no result of that command.
void check_to_resume(const std::string& folder, const std::string& command);

/// The JSON result that an interrupted run of a command left in the folder given by --resume. Removes files that were
/// incomplete when the run was killed. @throws std::invalid_argument if the result is missing, not valid, not of that command,
/// or of an unknown schema.
Json read_to_resume(const std::string& folder, const std::string& command);

/// @throws std::invalid_argument if the earlier result of --resume has another model, other parameters or other options than
/// the run that begins with `head`; the message names the first difference.
void check_same_run(const Json& earlier, const Json& head, const std::string& folder);

/// @throws std::invalid_argument saying why the result in a folder cannot be resumed.
[[noreturn]] void throw_not_resumable(const std::string& folder, const std::string& command, const std::string& why);

}  // namespace graze::apps
