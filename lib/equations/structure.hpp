// SPDX-License-Identifier: GPL-3.0-or-later
// Recognises in the expressions what the fast flows and the lanes know: oscillators, levels, rebounds.
//
// Nothing is declared: each finding is proved by expanding the expressions, for all values of states and parameters.
#pragma once

#include <graze/lib/equations/polynomial.hpp>
#include <graze/lib/system/hybrid_system.hpp>

namespace graze::equations {

/// The structure of the field of a mode with the states (x, v), as mode_structure.hpp has it: linear with constant coefficients
/// and a harmonic forcing, with a cubic spring, or with Hertz's contact. Empty: none of them. `contact_power` of x - r is
/// Hertz's law where r is the level of a guard. `parameters` is their number.
StructureAt recognise_structure(Graph& graph, const std::vector<Expression>& field, std::optional<std::size_t> forcing_frequency,
                                std::size_t parameters);

/// h = sign (x[coordinate] - p[level]).
std::optional<LevelGuard> recognise_level(Graph& graph, Expression guard);

/// A state that is a function of the others where h = 0, because h is linear in it with a number as coefficient.
struct Solution {
  std::size_t state;
  Expression value;
};
/// The state with the lowest number that `allowed` admits.
std::optional<Solution> solve_guard(Graph& graph, Expression guard, std::size_t states,
                                    const std::function<bool(std::size_t state)>& allowed);

/// Whether e is proved to vanish where the guard does: it is a multiple of the guard, or vanishes where a state, or a
/// function of the states such as sqrt(x^2 + y^2), is replaced by its value on the guard.
bool vanishes_on(Graph& graph, Expression e, Expression guard, const std::vector<ParameterInfo>& parameters);

/// x+ = p[level], v+ = -p[coefficient] v at a guard that is a level of x; all other states stay.
std::optional<Rebound> recognise_rebound(Graph& graph, const std::vector<Expression>& map,
                                         const std::optional<LevelGuard>& level);

}  // namespace graze::equations
