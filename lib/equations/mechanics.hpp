// SPDX-License-Identifier: GPL-3.0-or-later
// Mechanics as modes and events: M q'' + C q' + K q = force with stops and dry friction (system_text.hpp). Internal.
//
// Each stop is open, closed or apart (a force law that does not pull has ended, but the gap has not opened). Each friction
// slips forward, slips backward or sticks. Every combination is a mode; its name lists the contacts that are not at rest:
// "free", "right", "left+right". A closed rigid stop and sticking friction are constraints: the accelerations follow from M
// with Lagrange multipliers
//     G M^-1 G^T lambda = -(G q'')_free,    q'' = q''_free + M^-1 G^T lambda,
// where the rows of G are the gradients of gap' and of the sliding speed in the velocities. States that a constraint determines
// from the others are replaced by functions of those, so that the motion does not drift off the constraint. A combination with
// dependent constraints is not a mode.
//
// Events of a rigid stop: the impact, its accumulation into the mode with the stop closed, and the release where gap'' > 0
// without the stop. An impulse that reaches a closed rigid stop through M opens it; friction then continues with the sign of
// its speed. Events of friction: its speed vanishes (it sticks if |lambda| is below the static limit, otherwise it slips the
// other way), and the multiplier reaches the limit.
#pragma once

#include <graze/lib/equations/names.hpp>
#include <graze/lib/equations/pieces.hpp>
#include <graze/lib/equations/structure.hpp>

namespace graze::equations {

/// Largest number of modes from contacts.
inline constexpr std::size_t max_contact_modes = 256;

/// The rate of e along a field; only the entries on which e depends are requested.
Expression rate_along(Graph& graph, Expression e, const std::function<Expression(std::size_t state)>& field);
Expression rate_along(Graph& graph, Expression e, const std::vector<Expression>& field);

/// A state that e = 0 determines from the others, because e is linear in it with a coefficient that is constant along the
/// motion.
std::optional<Solution> solve_constraint(const Names& names, Expression e, const std::function<bool(std::size_t)>& allowed);

/// The modes and events of the mechanics. @throws EquationError
Pieces make_mechanics(Names& names);

}  // namespace graze::equations
