// SPDX-License-Identifier: GPL-3.0-or-later
// Results that are read back: files as a whole, and JSON from their text.
#pragma once

#include <graze/apps/text/json.hpp>

#include <string>

namespace graze::apps {

/// The content of a result file, which must be a regular one. @throws std::invalid_argument in one sentence that names the file.
std::string read_whole(const std::string& file);

/// @throws std::invalid_argument with the place where it is damaged.
Json parse_json(const std::string& text);

/// @throws std::invalid_argument if there is no result of that command in the folder given by --resume.
void check_to_resume(const std::string& folder, const std::string& command);

/// The JSON result that an interrupted run of a command left in the folder given by --resume. What it was writing when it was
/// killed is removed. @throws std::invalid_argument if the result is not there, not valid, not of that command, or of a
/// schema that is not known.
Json read_to_resume(const std::string& folder, const std::string& command);

/// @throws std::invalid_argument if the earlier result of --resume is of another model, other parameters or other options than
/// the one that begins with `head`; the message names the first of them.
void check_same_run(const Json& earlier, const Json& head, const std::string& folder);

/// Throws the std::invalid_argument that says why the result in a folder cannot be gone on with.
[[noreturn]] void refuse_to_resume(const std::string& folder, const std::string& command, const std::string& why);

}  // namespace graze::apps
