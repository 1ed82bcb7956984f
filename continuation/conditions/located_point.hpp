// SPDX-License-Identifier: GPL-3.0-or-later
// LocatedPoint: a bifurcation as its extended system locates it. K is the matrix of the multiplier condition
// (multiplier_condition.hpp), H(u) = 0 the equations of the branch.
#pragma once

#include <graze/lib/numerics/newton.hpp>

namespace graze {

struct LocatedPoint {
  NewtonReport newton;
  Vector u;                ///< unknowns of the branch at the point, the parameter's value last
  double theta = 0.0;      ///< radians
  double precision = 0.0;  ///< estimated error of the parameter's value
  Eigen::VectorXcd v, w;   ///< right and left null vectors of K at the point (as many entries as H)
};

}  // namespace graze
