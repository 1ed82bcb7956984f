// SPDX-License-Identifier: GPL-3.0-or-later
// search_box: where periodic orbits may be looked for.
#pragma once

#include <graze/lib/motion/propagator.hpp>
#include <graze/lib/motion/transition.hpp>

#include <utility>

namespace graze {

/// A box that holds the bounded motions: as large as motions from rest get, as those get in the long run that start off the
/// barriers and hit them, and as the distance of the barriers, all times 1.5.
/// Each motion is carried for so many forcing periods, unless it has settled before.
std::pair<Vector, Vector> search_box(const HybridSystem& system, const Vector& p, const FlowOptions& options = {},
                                     int periods = 300);

}  // namespace graze
