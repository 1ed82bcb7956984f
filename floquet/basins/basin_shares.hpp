// SPDX-License-Identifier: GPL-3.0-or-later
// Sizes of the basins, computed from the outcomes of the starts.
#pragma once

#include <graze/floquet/basins/basins.hpp>

namespace graze {

/// Fills in counts, fractions and their errors; sorts by decreasing basin (equal ones by their states).
Basins with_shares(Basins basins);

}  // namespace graze
