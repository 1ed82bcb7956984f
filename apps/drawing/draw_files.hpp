// SPDX-License-Identifier: GPL-3.0-or-later
// Drawing pictures into files: several at a time, since each keeps one core busy.
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
  std::function<Picture()> picture;  ///< called concurrently for several drawings
};

/// Draws and writes the pictures, one per thread at a time. Without gnuplot it draws none and says so on console.err. A picture
/// that cannot be drawn or written does not affect the others; at the end `complain` receives one sentence for it. `drawn(k)`
/// is called after each picture, one call at a time. False: the user interrupted the drawing; pictures not begun by then are
/// left out.
bool draw_into_files(const std::vector<Drawing>& drawings, const Console& console,
                     const std::function<void(const std::string& sentence)>& complain,
                     const std::function<void(std::size_t k)>& drawn = {});

}  // namespace graze::apps
