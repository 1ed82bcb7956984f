// SPDX-License-Identifier: GPL-3.0-or-later
// The defining equations of a branch point (a crossing of two branches), with one unfolding parameter e (Beyn et al., Handbook of
// Dynamical Systems 2 (2002), ch. 4):
//     H(u) + e b = 0,   g(u) = 0,   w^T H_p(u) = 0,
// with g and w from the bordered matrix K(1) (see multiplier_equations.hpp). The last two equations state that the Jacobian in
// the states is singular, and that the parameter's column H_p lies in its range. At a branch point e = 0. An imperfection opens
// the crossing: then e != 0, and no branch point is reported.
#pragma once

#include <graze/continuation/conditions/defining_equations.hpp>

#include <memory>

namespace graze {

/// If |e| >= 1e-8 at the solution, the point that locate() returns is not converged. LocatedPoint::v is the null vector;
/// LocatedPoint::w stays empty.
std::unique_ptr<DefiningEquations> branch_point_equations();

}  // namespace graze
