// SPDX-License-Identifier: GPL-3.0-or-later
// Results that are read back: files as a whole, and JSON from their text.
#pragma once

#include <graze/apps/json.hpp>

#include <string>

namespace graze::apps {

/// The content of a result file, which must be a regular one. @throws std::invalid_argument in one sentence that names the file.
std::string read_whole(const std::string& file);

/// @throws std::invalid_argument with the place where it is damaged.
Json parse_json(const std::string& text);

}  // namespace graze::apps
