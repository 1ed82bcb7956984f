// SPDX-License-Identifier: GPL-3.0-or-later
// BranchProblem: periodic orbits in one parameter as a curve, whatever its coordinates: states at fixed phases (OrbitProblem), or
// instants and states at the events of a fixed signature (SignatureProblem). The parameter's value is the last unknown.
#pragma once

#include <graze/continuation/branch.hpp>
#include <graze/continuation/zero_problem.hpp>

namespace graze {

class OrbitProblem;

class BranchProblem {
 public:
  virtual ~BranchProblem() = default;

  virtual Eigen::Index unknowns() const = 0;
  virtual ZeroProblem zero_problem() = 0;
  /// The small record of the orbit at u that a branch keeps, and the orbit with everything known of it.
  virtual BranchPoint branch_point(const Vector& u, double arclength) = 0;
  virtual PeriodicOrbit orbit(const Vector& u, NewtonReport report) = 0;
  /// The same orbit in states at fixed phases, in which special points are located. The reference holds until the next call.
  virtual OrbitProblem& stroboscopic(const Vector& u, Vector& out) = 0;

  /// Dimensionless time carried so far: the measure of cost.
  virtual double time_carried() const = 0;

  double value(const Vector& u) const { return u[u.size() - 1]; }
  /// Direction in which only the parameter changes.
  Vector parameter_direction() const { return Vector::Unit(unknowns(), unknowns() - 1); }
};

/// A value that the corrector's rounding has carried just beyond the range of a parameter is put back onto its end.
double within_range(const ParameterInfo& parameter, double value);

}  // namespace graze
