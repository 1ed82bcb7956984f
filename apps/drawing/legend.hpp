// SPDX-License-Identifier: GPL-3.0-or-later
// Legend: the entries below a picture's axes, and the room they take.
#pragma once

#include <graze/apps/drawing/picture.hpp>

#include <cstddef>
#include <string>

namespace graze::apps {

inline constexpr const char* barrier_style = "with lines lc rgb '#b22222' lw 1.8 dt 1";

struct Legend {
  std::size_t rows = 0, columns = 3;
  std::size_t titles = 0;    ///< number of curves with an entry: the first ones
  std::size_t left_out = 0;  ///< number of curves without room for an entry; one more entry says so
  int font = 13;
  double row_height() const { return font < 11 ? 0.9 : font < 13 ? 1.05 : 1.25; }  ///< in characters of the picture
};

/// The legend of a picture. With any number of titles, most of the sheet is left to the axes.
Legend legend_of(const Picture& picture);

/// "and 12 more".
std::string left_out_entry(const Legend& legend);

}  // namespace graze::apps
