// SPDX-License-Identifier: GPL-3.0-or-later
// Recognises the structures for which fast flows and SIMD lanes exist: oscillators, levels, rebounds.
#pragma once

#include <graze/lib/equations/polynomial.hpp>
#include <graze/lib/system/hybrid_system.hpp>

namespace graze::equations {

/// The structure of the field of a mode with the states (x, v), as in mode_structure.hpp: linear with constant coefficients and
/// harmonic forcing, with a cubic spring, or with Hertz's contact. Empty: none of them. `contact_power` of x - r is Hertz's law
/// if r is the level of a guard. `parameters`: number of parameters.
StructureAt recognise_structure(Graph& graph, const std::vector<Expression>& field, std::optional<std::size_t> forcing_frequency,
                                std::size_t parameters);

/// The level guard h = sign (x[coordinate] - p[level]), if `guard` is one.
std::optional<LevelGuard> recognise_level(Graph& graph, Expression guard);

/// A state determined by the others on h = 0, because h is linear in it with a number as coefficient.
struct Solution {
  std::size_t state;
  Expression value;
};
/// Solves guard = 0 for the first state that `allowed` admits and for which that is possible.
std::optional<Solution> solve_guard(Graph& graph, Expression guard, std::size_t states,
                                    const std::function<bool(std::size_t state)>& allowed);

/// True if e is proved to vanish where the guard does: it is a multiple of the guard, or it vanishes if a state, or a function
/// of the states such as sqrt(x^2 + y^2), is replaced by its value on the guard.
bool vanishes_on(Graph& graph, Expression e, Expression guard, const std::vector<ParameterInfo>& parameters);

/// The rebound x+ = p[level], v+ = -p[coefficient] v at a guard that is a level of x, with all other states unchanged; nullopt:
/// the map is none.
std::optional<Rebound> recognise_rebound(Graph& graph, const std::vector<Expression>& map,
                                         const std::optional<LevelGuard>& level);

}  // namespace graze::equations
