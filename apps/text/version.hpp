// SPDX-License-Identifier: GPL-3.0-or-later
// The version of the program, from CMake's project().
#pragma once

namespace graze::apps {

inline constexpr const char* program_version = GRAZE_VERSION;

}  // namespace graze::apps
