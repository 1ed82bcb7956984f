// SPDX-License-Identifier: GPL-3.0-or-later
// The defining equations of a bifurcation of multipliers: the orbit's equations H(u) = 0, and the condition that
// sigma = e^{i theta} is a multiplier, in minimally augmented form (Govaerts, Numerical Methods for Bifurcations, 2000, ch. 4):
//     [K(sigma)  b] [v]   [0]
//     [c^H       0] [g] = [1],      g(u, theta) = 0,       dg = -w^H (dK) v,
// with b and c near the left and right null vectors of K, and w the solution of the adjoint system. Fold: theta = 0; period
// doubling: theta = pi; Neimark-Sacker: theta is unknown.
//
// K is the matrix in the branch's own coordinates (BranchProblem::cyclic). In the coordinates of the events of a signature it
// stays regular when the speed of an impact goes to zero: there det K is the determinant for the return map times the speeds of
// the impacts.
#pragma once

#include <graze/continuation/conditions/defining_equations.hpp>

#include <memory>

namespace graze {

struct MultiplierCondition {
  double theta = 0.0;       ///< radians; the first guess if it is free
  bool theta_free = false;  ///< theta is an unknown (Neimark-Sacker); otherwise theta is 0 or pi
};

/// The equations must be regular: with theta free, the multiplier must leave the unit circle there.
std::unique_ptr<DefiningEquations> multiplier_equations(const MultiplierCondition& condition);

}  // namespace graze
