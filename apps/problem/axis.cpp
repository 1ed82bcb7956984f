// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/problem/axis.hpp>
#include <graze/apps/text/number.hpp>

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

namespace graze::apps {

namespace {

std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  return parts;
}

/// An axis from the parts A, B and, if given, N. Messages begin with `given`, the option as it was given.
Axis axis_from(const std::vector<std::string>& parts, const std::string& given, const std::string& form) {
  const auto refuse = [&given](const std::string& why) { return std::invalid_argument(given + ": " + why); };
  const auto from = parse_number(parts[0]), to = parse_number(parts[1]);
  if (!from || !to || !std::isfinite(*from) || !std::isfinite(*to)) throw refuse("must be " + form);
  Axis axis;
  axis.from = *from;
  axis.to = *to;
  if (parts.size() == 3) {
    const auto count = parse_count(parts[2]);
    if (!count || *count < 1)
      throw refuse(fmt::format("the number of values must be a whole number >= 1 and <= {}", std::numeric_limits<int>::max()));
    axis.count = *count;
  }
  if (axis.from > axis.to || (axis.from == axis.to && axis.count > 1))
    throw refuse(fmt::format("{} needs A < B; A is {}, B is {}", parts.size() == 3 ? "A:B:N" : "A:B", parts[0], parts[1]));
  return axis;
}

}  // namespace

Axis parse_axis(std::string_view option, const std::string& text, bool counted) {
  const std::vector<std::string> parts = parts_of(text);
  const std::string given = fmt::format("{} {}", option, text);
  const std::string form = counted ? "A:B:N, N values from A to B, for example -2:1.9:64" : "A:B, a range, for example -2:1.9";
  if (parts.size() < 2 || parts.size() > (counted ? 3U : 2U)) throw std::invalid_argument(given + ": must be " + form);
  return axis_from(parts, given, form);
}

std::pair<std::string, Axis> parse_named_axis(std::string_view option, const std::string& text) {
  const std::vector<std::string> parts = parts_of(text);
  const std::string given = fmt::format("{} {}", option, text);
  const std::string form = "NAME:A:B:N, N values from A to B, for example eta:0.65:0.95:200";
  if (parts.size() != 4 || parts[0].empty()) throw std::invalid_argument(given + ": must be " + form);
  return {parts[0], axis_from({parts.begin() + 1, parts.end()}, given, form)};
}

}  // namespace graze::apps
