// SPDX-License-Identifier: GPL-3.0-or-later
// The extended system of a branch point (a crossing of two branches), with one unfolding parameter e (Beyn et al., Handbook of
// Dynamical Systems 2 (2002), ch. 4):  H(u) + e b = 0,  g(u) = 0,  w^T H_p(u) = 0,
// with g and w from the bordered matrix K(1): the Jacobian in the states is singular and the parameter's column lies in its
// range. At the point e = 0; a crossing that an imperfection has opened leaves e != 0, and is not reported as a branch point.
#pragma once

#include <graze/continuation/conditions/multiplier_condition.hpp>

namespace graze {

LocatedPoint locate_branch_point(BranchProblem& problem, const Vector& u);

}  // namespace graze
