// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures on their way into files: several are drawn at a time, since each of them keeps one core busy.
#pragma once

#include <graze/apps/picture.hpp>

#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

struct Drawing {
  std::string file;
  std::function<Picture()> picture;
};

/// Draws them, as many at a time as `threads`, and writes them in their order. What cannot be drawn or written is told to
/// `complain`, in one sentence, and costs no other. False: who runs the program has interrupted the drawing; what was not begun
/// by then is left out.
bool draw_into_files(const std::vector<Drawing>& drawings, int threads,
                     const std::function<void(const std::string& sentence)>& complain);

}  // namespace graze::apps
