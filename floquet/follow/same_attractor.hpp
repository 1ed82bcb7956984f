// SPDX-License-Identifier: GPL-3.0-or-later
// Whether two rows of a sweep at the same value are on the same attractor.
#pragma once

#include <graze/floquet/follow/sweep.hpp>

namespace graze {

/// Orbits: n, p and their states agree to within 1e-8 of 1 + |x|. Chaos: their exponents agree to within five standard errors,
/// and their states are as near to those of the other as to each other. What is undecided is on no attractor that is known.
bool on_same_attractor(const SweepRow& a, const SweepRow& b);

}  // namespace graze
