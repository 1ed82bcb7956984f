// SPDX-License-Identifier: GPL-3.0-or-later
// How the program's JSON is broken into lines: what fits stands on one, and so does an array of numbers or texts, however long.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace graze::apps {

constexpr std::size_t json_line_width = 110;

/// Appends to `out` what stands in `flat` on one line without blanks (Json::dump()). Lines below the first begin with `indent`
/// blanks and more; indent 0 is that of a whole document, which is broken in any case.
void lay_out(std::string_view flat, std::size_t indent, std::string& out);

}  // namespace graze::apps
