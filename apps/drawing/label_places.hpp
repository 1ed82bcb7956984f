// SPDX-License-Identifier: GPL-3.0-or-later
// Placement of the words of labels: they cover neither each other nor the curves, and stay inside the picture.
#pragma once

#include <graze/apps/drawing/picture.hpp>

#include <vector>

namespace graze::apps {

/// Place of a label's words relative to its mark, in characters.
struct LabelPlace {
  double right = 1.0, up = 0.7;  ///< from the mark to the near end of the words
  bool leftwards = false;        ///< the words end at that point instead of beginning there
  bool far = false;              ///< far enough that a line should lead to the mark
  bool free = true;              ///< false: there was no room, and the words are left out
};

/// Whether there are too many words for free placement: they then keep off the curves, or are left out.
bool is_crowd(const std::vector<Label>& labels);

/// One place per label; `x` and `y` are the ranges of the axes, `curves` the curves drawn in them, `rows` and `columns` the
/// height and width of the axes in characters.
std::vector<LabelPlace> label_places(const std::vector<Label>& labels, const std::array<double, 2>& x,
                                     const std::array<double, 2>& y, const std::vector<Curve>& curves = {}, double rows = 26.0,
                                     double columns = 92.0);

}  // namespace graze::apps
