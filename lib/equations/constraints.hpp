// SPDX-License-Identifier: GPL-3.0-or-later
// Constraints e = 0 on the motion: the rate of e along a field, and the state that the constraint determines from the others.
// Mechanics, surfaces and the rates in a text need both. Internal.
#pragma once

#include <graze/lib/equations/names.hpp>
#include <graze/lib/equations/structure.hpp>

namespace graze::equations {

/// The rate of e along a field; only the entries on which e depends are requested.
Expression rate_along(Graph& graph, Expression e, const std::function<Expression(std::size_t state)>& field);
Expression rate_along(Graph& graph, Expression e, const std::vector<Expression>& field);

/// A state that e = 0 determines from the others, because e is linear in it with a coefficient that is constant along the
/// motion.
std::optional<Solution> solve_constraint(const Names& names, Expression e, const std::function<bool(std::size_t)>& allowed);

}  // namespace graze::equations
