// SPDX-License-Identifier: GPL-3.0-or-later
// search_box: where periodic orbits may be looked for.
#pragma once

#include <graze/lib/motion/propagator.hpp>
#include <graze/lib/motion/transition.hpp>

namespace graze {

struct SearchBox {
  Vector lower, upper;
  /// What ended the first period of motions from rest and from beside it, if none of them came through it: then there is nothing
  /// to search. time: all is well.
  Termination ended = Termination::time;
  /// Steps of one stretch of a motion beyond which a start is not worth them (FlowOptions::max_steps): several times as many as
  /// the longest stretch took of the motions that made the box.
  std::size_t max_steps = 0;
};

/// A box that holds the bounded motions: as large as motions from rest get, as those get in the long run that start off the
/// barriers and hit them, and as the distance of the barriers, all times 1.5.
/// Each motion is carried for so many forcing periods, unless it has settled before.
SearchBox search_box(const HybridSystem& system, const Vector& p, const FlowOptions& options = {}, int periods = 300);

}  // namespace graze
