// SPDX-License-Identifier: GPL-3.0-or-later
// abs, sign, max, min and step (clamp and deadzone consist of them) of what moves become modes and guards. Internal.
//
// Each function changes its branch where its argument (a - b of max and min) changes its sign. A mode becomes one mode for each
// combination of signs that makes a difference and is not refuted by bounds; where an argument rises or falls through zero, an
// event leads to the mode with the other sign. It is continuous where only abs, max and min bend there; at a jump of sign or
// step the field jumps. A motion that is pressed onto such a jump from both sides slides along it (Filippov). That is not handled
// here, the events follow each other without end: write it as friction or as a surface (system_text.hpp).
//
// Where the branch behind a reset is not known beforehand, the event becomes several with the same guard (Alternative), one for
// each branch that the reset may lead to.
#pragma once

#include <graze/lib/equations/pieces.hpp>

namespace graze::equations {

/// abs, sign, max, min or step.
bool is_nonsmooth(Operation operation);

/// Of such a node: where this changes its sign, the function changes its branch.
Expression switching_argument(Graph& graph, const Node& node);

/// Modes that one mode of the text may become.
inline constexpr std::size_t most_split_modes = 64;

/// @throws EquationError where it becomes more.
Pieces split_nonsmooth(Graph& graph, const Pieces& pieces, const std::vector<ParameterInfo>& parameters, const Symbols& symbols,
                       const Source& source);

}  // namespace graze::equations
