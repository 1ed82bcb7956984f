// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/legend.hpp>

#include <fmt/format.h>

#include <algorithm>

namespace graze::apps {

namespace {

constexpr std::size_t most_rows = 9;  // of small letters: a fifth of the sheet

}  // namespace

Legend legend_of(const Picture& picture) {
  Legend legend;
  std::size_t others = picture.unit_circle ? 1 : 0, longest = 0;
  for (const Barrier& barrier : picture.barriers) others += barrier.text.empty() ? 0 : 1;
  for (const Curve& curve : picture.curves) {
    legend.titles += curve.title.empty() ? 0 : 1;
    longest = std::max(longest, curve.title.size());
  }
  legend.columns = picture.legend_columns > 0 ? picture.legend_columns : longest > 24 ? 2 : 3;
  const std::size_t most = most_rows * legend.columns;
  if (legend.titles + others > most) {
    const std::size_t shown = most - std::min(most, others + 1);
    legend.left_out = legend.titles - shown;
    legend.titles = shown;
    ++others;
  }
  legend.rows = (legend.titles + others + legend.columns - 1) / legend.columns;
  legend.font = legend.rows > 5 ? 9 : legend.rows > 4 ? 11 : 13;
  return legend;
}

std::string left_out_entry(const Legend& legend) { return fmt::format("and {} more", legend.left_out); }

}  // namespace graze::apps
