// SPDX-License-Identifier: GPL-3.0-or-later
// What the soft laws share: a mode "contact" for x >= r, entered and left with a continuous state and field.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

namespace graze {

/// Adds the contact mode, the events "enter" and "leave", and initial_mode (on the barrier: by speed, at rest by acceleration).
void attach_soft_contact(HybridSystem& system, Mode contact);

}  // namespace graze
