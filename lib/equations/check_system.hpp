// SPDX-License-Identifier: GPL-3.0-or-later
// Checks of a system from text at the parameters and the start of its file: nothing divides by zero, the field has the stated
// period, and no reset leaves the state beyond its guard. Internal.
#pragma once

#include <graze/lib/equations/names.hpp>
#include <graze/lib/equations/pieces.hpp>

namespace graze::equations {

/// @throws EquationError with the place of the failure.
void check_system(const HybridSystem& system, const Names& names, const Pieces& pieces);

}  // namespace graze::equations
