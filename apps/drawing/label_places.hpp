// SPDX-License-Identifier: GPL-3.0-or-later
// Where the words of labels go, so that they neither cover each other nor leave the picture, and keep off its curves.
#pragma once

#include <graze/apps/drawing/picture.hpp>

#include <vector>

namespace graze::apps {

/// Place of a label's words relative to its mark, in characters.
struct LabelPlace {
  double right = 1.0, up = 0.7;  ///< from the mark to the near end of the words
  bool leftwards = false;        ///< the words end there instead of beginning
  bool far = false;              ///< so far that a line should lead to the mark
  bool free = true;              ///< false: there was no room, and the words are left away
};

/// Whether there are more words than fit where they please: they then keep off the curves, or are left away.
bool is_crowd(const std::vector<Label>& labels);

/// One place per label; `x` and `y` are the ranges of the axes, `curves` what is drawn in them, `rows`
/// and `columns` how high and wide they are.
std::vector<LabelPlace> label_places(const std::vector<Label>& labels, const std::array<double, 2>& x,
                                     const std::array<double, 2>& y, const std::vector<Curve>& curves = {}, double rows = 26.0,
                                     double columns = 92.0);

}  // namespace graze::apps
