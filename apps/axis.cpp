// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/axis.hpp>
#include <graze/apps/number.hpp>

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <vector>

namespace graze::apps {

Axis parse_axis(std::string_view option, const std::string& text, bool counted) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  const auto refuse = [&](const std::string& why) -> std::invalid_argument {
    return std::invalid_argument(fmt::format("{} {}: {}", option, text, why));
  };
  const std::string form = counted ? "a:b:n, n values from a to b, for example -2:1.9:64" : "a:b, a range, for example -2:1.9";
  if (parts.size() < 2 || parts.size() > (counted ? 3U : 2U)) throw refuse("must be " + form);
  const auto from = parse_number(parts[0]), to = parse_number(parts[1]);
  if (!from || !to || !std::isfinite(*from) || !std::isfinite(*to)) throw refuse("must be " + form);
  Axis axis;
  axis.from = *from;
  axis.to = *to;
  if (parts.size() == 3) {
    const auto count = parse_count(parts[2]);
    if (!count || *count < 1) throw refuse("the number of values must be a whole number >= 1");
    axis.count = *count;
  }
  if (axis.from > axis.to || (axis.from == axis.to && axis.count > 1)) throw refuse("the range must go from less to more");
  return axis;
}

}  // namespace graze::apps
