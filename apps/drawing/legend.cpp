// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/drawing/legend.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace graze::apps {

namespace {

/// A font size of the legend: the largest number of rows for which it is used, and the longest entry in characters with which
/// three columns, or two, find room below axes of the usual width. Measured with gnuplot 5.4 (whose estimate of a text's width
/// decides), with two characters in reserve for wide tics. With longer entries gnuplot makes fewer columns than requested, and
/// more rows than there is room for.
struct Letters {
  int font;
  std::size_t most_rows, in_three_columns, in_two_columns;
};
constexpr std::array sizes = {Letters{13, 4, 21, 36}, Letters{11, 5, 27, 45}, Letters{9, 9, 32, 52}};

std::size_t characters(const std::string& utf8) {
  return static_cast<std::size_t>(
      std::count_if(utf8.begin(), utf8.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

Legend legend_of(const Picture& picture) {
  Legend legend;
  std::size_t titles = 0, others = picture.unit_circle ? 1 : 0, longest = 0;
  for (const Barrier& barrier : picture.barriers) {
    others += barrier.text.empty() ? 0 : 1;
    longest = std::max(longest, characters(barrier.text));
  }
  for (const Curve& curve : picture.curves) {
    titles += curve.title.empty() ? 0 : 1;
    longest = std::max(longest, characters(curve.title));
  }
  for (const Letters& letters : sizes) {
    legend.font = letters.font;
    legend.columns = picture.legend_columns > 0            ? picture.legend_columns
                     : longest <= letters.in_three_columns ? 3
                     : longest <= letters.in_two_columns   ? 2
                                                           : 1;
    legend.rows = (titles + others + legend.columns - 1) / legend.columns;
    if (legend.rows <= letters.most_rows) break;
  }
  legend.titles = titles;
  const std::size_t most = sizes.back().most_rows * legend.columns;  // a fifth of the sheet
  if (titles + others <= most) return legend;
  legend.titles = most - std::min(most, others + 1);
  legend.left_out = titles - legend.titles;
  legend.rows = sizes.back().most_rows;
  return legend;
}

std::string left_out_entry(const Legend& legend) { return fmt::format("and {} more", legend.left_out); }

}  // namespace graze::apps
