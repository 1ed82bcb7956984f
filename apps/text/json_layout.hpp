// SPDX-License-Identifier: GPL-3.0-or-later
// The line breaks of the program's JSON: a value that fits stands on one line, and so does an array of numbers or texts of any
// length.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace graze::apps {

constexpr std::size_t json_line_width = 110;

/// Appends the value `flat`, given on one line without blanks (Json::dump()), to `out`. Every line after the first is indented
/// by at least `indent` blanks. Indent 0 is a whole document, which is always broken into lines.
void lay_out(std::string_view flat, std::size_t indent, std::string& out);

}  // namespace graze::apps
