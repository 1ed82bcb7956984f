// SPDX-License-Identifier: GPL-3.0-or-later
// Which shares of the starts the basins have, by their outcomes.
#pragma once

#include <graze/floquet/basins/basins.hpp>

namespace graze {

/// Counts, fractions and their errors, with the largest basin first (equal ones in the order of their states).
Basins with_shares(Basins basins);

}  // namespace graze
