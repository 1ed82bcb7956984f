// SPDX-License-Identifier: GPL-3.0-or-later
// Files that are read whole.
#pragma once

#include <string>

namespace graze::apps {

/// The content of a result file. @throws std::invalid_argument in one sentence that names the file.
std::string read_whole(const std::string& file);

}  // namespace graze::apps
