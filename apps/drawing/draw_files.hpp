// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures on their way into files: several are drawn at a time, since each of them keeps one core busy.
#pragma once

#include <graze/apps/console/console.hpp>
#include <graze/apps/drawing/picture.hpp>

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace graze::apps {

struct Drawing {
  std::string file;
  std::function<Picture()> picture;  ///< those of several are asked for at the same time
};

/// Draws and writes them, as many at a time as there are threads; without gnuplot none of them, which is said on console.err.
/// What cannot be drawn or written costs no other, and is told to `complain` in the end, in one sentence. `drawn(k)` is told of
/// each that is done with, one at a time. False: who runs the program has interrupted the drawing; what was not begun by then is
/// left out.
bool draw_into_files(const std::vector<Drawing>& drawings, const Console& console,
                     const std::function<void(const std::string& sentence)>& complain,
                     const std::function<void(std::size_t k)>& drawn = {});

}  // namespace graze::apps
