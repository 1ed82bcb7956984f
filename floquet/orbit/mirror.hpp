// SPDX-License-Identifier: GPL-3.0-or-later
// The mirror image of an orbit, x(t) -> S x(t + s T), under a symmetry of the system (lib/system/symmetry.hpp): a second orbit,
// or the same one, which is then symmetric.
#pragma once

#include <graze/lib/motion/transition.hpp>
#include <graze/lib/system/symmetry.hpp>

#include <optional>
#include <vector>

namespace graze {

/// S x(s T) of the motion from x at forcing phase 0. Empty if it cannot be carried there.
std::optional<Vector> mirrored_state(Propagator& propagator, const Symmetry& symmetry, const Vector& x);

/// The states at forcing phase 0 of the mirror image of the orbit with these states at forcing phase 0 (without forcing: states
/// of the image of an orbit with these states). Empty if it is not an orbit of the system, or if a motion cannot be continued.
std::vector<Vector> mirror_image(const HybridSystem& system, const Vector& p, const Symmetry& symmetry,
                                 const std::vector<Vector>& states);

}  // namespace graze
