// SPDX-License-Identifier: GPL-3.0-or-later
// LocatedPoint: a bifurcation as its extended system locates it. K is the matrix of the multiplier condition
// (multiplier_condition.hpp), H(u) = 0 the equations of the branch. A condition must set newton, u and precision. The other
// members are for its own `describe`.
#pragma once

#include <graze/lib/numerics/newton.hpp>

namespace graze {

struct LocatedPoint {
  NewtonReport newton;
  Vector u;                ///< unknowns of the branch at the point, the parameter's value last
  double theta = 0.0;      ///< radians
  double precision = 0.0;  ///< estimated error of the parameter's value, in its unit; 0 if Newton's method fails
  Eigen::VectorXcd v, w;   ///< right and left null vectors of K at the point (as many entries as H)
};

}  // namespace graze
