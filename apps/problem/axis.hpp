// SPDX-License-Identifier: GPL-3.0-or-later
// Axis: equally spaced values of one coordinate, in the form of the command line: A:B:N.
#pragma once

#include <string>
#include <string_view>
#include <utility>

namespace graze::apps {

/// First value, last value, and number of values.
struct Axis {
  double from = 0.0, to = 0.0;
  int count = 64;
  double at(int i) const { return count == 1 ? from : i == count - 1 ? to : from + i * ((to - from) / (count - 1)); }
};

/// "A:B:N", or "A:B" for 64 values; not `counted`: only a range "A:B". `option` is the name used in messages.
/// @throws std::invalid_argument in one sentence.
Axis parse_axis(std::string_view option, const std::string& text, bool counted);

/// "NAME:A:B:N", as name and axis. @throws std::invalid_argument in one sentence.
std::pair<std::string, Axis> parse_named_axis(std::string_view option, const std::string& text);

}  // namespace graze::apps
