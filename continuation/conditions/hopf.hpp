// SPDX-License-Identifier: GPL-3.0-or-later
// The Hopf point at which a branch of an autonomous system ends: the orbit shrinks to an equilibrium, of which two eigenvalues
// +-i omega cross the imaginary axis there.
#pragma once

#include <graze/continuation/problems/orbit_problem.hpp>

#include <optional>

namespace graze {

/// The field at the first node of the orbit u. It vanishes, and changes its sign, where the orbit is an equilibrium. Empty for a
/// forced system.
Vector field_at_first_node(OrbitProblem& problem, const Vector& u);

/// The parameter at the Hopf point near the small orbit u, by the secant method on the real part of the eigenvalues, along the
/// equilibria f = 0 of the mode at the first node. Empty: the search does not converge near u.
std::optional<double> locate_hopf(OrbitProblem& problem, const Vector& u);

/// Whether the orbit u is so small that it cannot be told from an equilibrium.
bool is_equilibrium(OrbitProblem& problem, const Vector& u);

}  // namespace graze
