// SPDX-License-Identifier: GPL-3.0-or-later
// DefiningEquations: a bifurcation as equations F(w) = 0: those of the orbit, H(u) = 0, and conditions, in w = (u, s) with
// unknowns s of the conditions' own. With one free parameter they define a point: locate(). With two they define a curve, such as
// the period doublings in two parameters: curve_of().
#pragma once

#include <graze/continuation/problems/branch_problem.hpp>
#include <graze/lib/numerics/newton.hpp>

namespace graze {

/// A bifurcation as its defining equations locate it.
struct LocatedPoint {
  NewtonReport newton;
  Vector u;                ///< unknowns of the branch at the point, the parameter's value last
  double precision = 0.0;  ///< estimated error of the parameter's value, in its unit; 0 if Newton's method fails
  // What the equations themselves add (multiplier_equations.hpp).
  double theta = 0.0;     ///< radians
  Eigen::VectorXcd v, w;  ///< right and left null vectors of K at the point (as many entries as H)
};

class DefiningEquations {
 public:
  virtual ~DefiningEquations() = default;

  /// The first guess of the conditions' own unknowns; empty: they have none.
  virtual Vector own_start() const { return {}; }
  /// F(w), one equation more than unknowns of the orbit and of the conditions, and unless null its Jacobian. False: the equations
  /// cannot be evaluated at w. The equations may remember what an evaluation with Jacobian finds (null vectors, for example) for
  /// the next one; without, they take what they remember: `problem` may then be another representation of the same orbit.
  virtual bool evaluate(BranchProblem& problem, const Vector& w, Vector& F, Matrix* jacobian) = 0;
  /// Of the last evaluation with Jacobian: the size of what each equation compares. Its tolerance and its rounding are relative
  /// to it.
  virtual Vector sizes() const = 0;
  virtual NewtonRule rule() const { return newton_to_rounding(); }
  /// Whether Newton's method may end at w, where the next step has this length (relative).
  virtual bool may_end(BranchProblem&, const Vector& /*w*/, double /*length*/) { return true; }
  /// Adds what the equations know of the solution w, and may find that it is no point of this kind.
  virtual void describe(const Vector& /*w*/, LocatedPoint&) const {}
};

/// A solution of defining equations, and what its error follows from.
struct DefinedPoint {
  NewtonReport newton;
  Vector w, F;
  Vector row;              ///< of the inverse Jacobian: that of the parameter's value
  double last_step = 0.0;  ///< of the parameter's value; not taken
};

/// Newton's method on the equations from u. @throws std::invalid_argument unless the problem has one free parameter.
DefinedPoint solve(BranchProblem& problem, DefiningEquations& equations, const Vector& u);

/// The same point with its error: that of rounding in the equations, that of the steps of numerical flows, and the step that
/// Newton's method has not taken. @throws as solve().
LocatedPoint locate(BranchProblem& problem, DefiningEquations& equations, const Vector& u);

/// The equations for the tracer, with two free parameters: its unknowns are w. They refer to both arguments.
ZeroProblem curve_of(BranchProblem& problem, DefiningEquations& equations);
/// The unknowns w from which the tracer starts at u.
Vector start_of(const DefiningEquations& equations, const Vector& u);

}  // namespace graze
