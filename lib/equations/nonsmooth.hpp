// SPDX-License-Identifier: GPL-3.0-or-later
// Makes modes and guards of abs, sign, max, min and step (and of clamp and deadzone, which consist of them) whose argument
// depends on the motion, and of atan2 and of atan and tanh of quotients where they jump. Internal.
//
// Each function changes its branch where its argument (a - b for max and min) changes its sign. A mode becomes one mode for
// each combination of signs that makes a difference and that bounds do not exclude. Where an argument rises or falls through
// zero, an event leads to the mode with the other sign. The event is continuous if only abs, max and min bend there; at a jump
// of sign or step the field jumps. A motion pressed onto such a jump from both sides slides along it (Filippov). That is not
// handled here: the events would follow each other without end. Write it as friction or as a surface (system_text.hpp).
//
// Where such a function, atan or tanh contains a quotient, it also jumps where the divisor passes zero (poles.hpp), unless the
// equations are infinite there. All signs behind that event follow from the numerators. atan2(y, x) jumps where y changes its
// sign; for x > 0, where it does not, the event changes nothing.
//
// If the branch after a reset is not known beforehand, the event becomes several with the same guard (Alternative), one for
// each branch to which the reset may lead.
#pragma once

#include <graze/lib/equations/pieces.hpp>

namespace graze::equations {

/// True for abs, sign, max, min and step.
bool is_nonsmooth(Operation operation);

/// The argument of such a node: the function changes its branch where the argument changes its sign.
Expression switching_argument(Graph& graph, const Node& node);

/// Largest number of modes made from one mode of the text.
inline constexpr std::size_t max_split_modes = 64;

/// The pieces with the nonsmooth functions resolved. @throws EquationError if a mode becomes more than max_split_modes, or for
/// a combination that is not handled.
Pieces split_nonsmooth(Graph& graph, const Pieces& pieces, const std::vector<ParameterInfo>& parameters, const Symbols& symbols,
                       const Source& source);

}  // namespace graze::equations
