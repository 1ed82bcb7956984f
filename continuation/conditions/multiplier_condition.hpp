// SPDX-License-Identifier: GPL-3.0-or-later
// The extended system by which a bifurcation of multipliers is located: the orbit's equations H(u) = 0 with the condition that
// sigma = e^{i theta} is a multiplier, in minimally augmented form (Govaerts, Numerical Methods for Bifurcations, 2000, ch. 4):
//     [K(sigma)  b] [v]   [0]
//     [c^H       0] [g] = [1],      g(u, theta) = 0,       dg = -w^H (dK) v,
// with b, c near the left and right null vectors of K. Fold: theta = 0; period doubling: theta = pi; Neimark-Sacker: theta
// unknown.
//
// K is that of the branch's own coordinates (BranchProblem::cyclic). In those of the events of a signature it stays regular where
// an impact's speed goes to zero: there det K is that of the return map times the speeds.
#pragma once

#include <graze/continuation/problems/branch_problem.hpp>

#include <optional>

namespace graze {

struct MultiplierCondition {
  double theta = 0.0;
  bool theta_free = false;  ///< Neimark-Sacker
};

struct LocatedPoint {
  NewtonReport newton;
  Vector u;
  double theta = 0.0;
  double precision = 0.0;  ///< estimated error of the parameter's value
  Eigen::VectorXcd v, w;   ///< right and left null vectors of K at the point
};

/// Newton on the extended system from u.
LocatedPoint locate_multiplier(BranchProblem& problem, const Vector& u, const MultiplierCondition& condition);

}  // namespace graze
