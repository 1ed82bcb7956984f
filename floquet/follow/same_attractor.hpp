// SPDX-License-Identifier: GPL-3.0-or-later
// Whether two attractors found at the same value are on the same attractor.
#pragma once

#include <graze/floquet/follow/sweep.hpp>

namespace graze {

/// Orbits: n and p are equal, and the states agree to within 1e-8 of 1 + |x|. Chaos: the exponents agree to within five
/// standard errors, and the states of each are, on average, less than twice as far from those of the other as from their own
/// neighbours. Chaos with fewer than 32 states and undecided motions are never the same attractor.
bool on_same_attractor(const FollowedAttractor& a, const FollowedAttractor& b);

}  // namespace graze
