// SPDX-License-Identifier: GPL-3.0-or-later
// The mirror image of an orbit, x(t) -> -x(t + T/2): a second orbit wherever the system is its own mirror image half a forcing
// period later, as two barriers opposite each other with harmonic forcing are. An orbit that is its own image is symmetric.
#pragma once

#include <graze/lib/motion/transition.hpp>

#include <optional>
#include <vector>

namespace graze {

/// -x(T/2) of the motion from x at forcing phase 0. Empty where it cannot be carried there.
std::optional<Vector> mirrored_state(Propagator& propagator, const Vector& x);

/// Of the orbit through these states at forcing phase 0: the states of its mirror image at forcing phase 0. Empty if that is no
/// orbit of the system, or a motion cannot be carried on.
std::vector<Vector> mirror_image(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states);

}  // namespace graze
