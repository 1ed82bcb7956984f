// SPDX-License-Identifier: GPL-3.0-or-later
// The picture of a result that was written before, from its text, as graze plot draws it.
#pragma once

#include <graze/apps/pictures/maps.hpp>

#include <string>
#include <vector>

namespace graze::apps {

/// The part of a result to be drawn, as the options of graze plot give it; empty: the default.
struct ResultView {
  std::string kind = {}, x = {}, plane = {};
  std::vector<std::string> y = {}, layers = {};
};

/// --y of a map names one of its quantities. @throws std::invalid_argument for options that contradict each other.
MapView map_view(const ResultView& view);

/// `file` ends in .json or .csv, the format of the text. @throws std::invalid_argument with one sentence if it is damaged, or has
/// nothing of the part asked for.
Picture picture_of_text(const std::string& text, const std::string& file, const ResultView& view = {});

}  // namespace graze::apps
