// SPDX-License-Identifier: GPL-3.0-or-later
// BranchProblem: periodic orbits in one parameter as a curve, whatever its coordinates: states at fixed phases (OrbitProblem), or
// instants and states at the events of a fixed signature (SignatureProblem). The parameter's value is the last unknown.
#pragma once

#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/trace/zero_problem.hpp>

#include <algorithm>
#include <complex>
#include <memory>
#include <optional>
#include <vector>

namespace graze {

class OrbitProblem;

/// A state that keeps its value whatever the orbit does, as the place of a mass that friction holds all along: its closing
/// equation holds by itself. Orbits with any value in a band then form a continuum. The branch takes those with this value, and
/// the equation "the state has it at the first node" replaces the closing one. The multiplier +1 of that state is trivial.
struct PinnedState {
  Eigen::Index state = 0;
  double value = 0.0;
};

class BranchProblem {
 public:
  virtual ~BranchProblem() = default;

  virtual Eigen::Index unknowns() const = 0;
  virtual ZeroProblem zero_problem() = 0;
  /// The small record of the orbit at u that a branch keeps, and the orbit with everything known of it.
  virtual BranchPoint branch_point(const Vector& u, double arclength) = 0;
  virtual PeriodicOrbit orbit(const Vector& u, NewtonReport report) = 0;
  /// The same orbit in states at fixed phases. The reference holds until the next call.
  virtual OrbitProblem& stroboscopic(const Vector& u, Vector& out) = 0;

  /// K(sigma) at u: the derivative of the equations in the orbit's own unknowns, with the link from the last node to the first
  /// multiplied by sigma. It is singular where sigma is a multiplier. The equations have been evaluated at u.
  virtual Eigen::MatrixXcd cyclic(const Vector& u, std::complex<double> sigma) = 0;
  /// w^H (dK/du_i) v for every unknown u_i (the value last), by central differences at u.
  virtual Eigen::VectorXcd cyclic_derivative(const Vector& u, std::complex<double> sigma, const Eigen::VectorXcd& w,
                                             const Eigen::VectorXcd& v) = 0;
  /// Whether the solution u is a motion: one of a fixed signature may pass through a barrier.
  virtual bool is_motion(const Vector&) { return true; }
  /// The hard events that the unknowns belong to, in order; nullopt for states at fixed phases.
  virtual std::optional<std::vector<std::size_t>> sequence() const { return std::nullopt; }
  /// Size of the orbit's states, 1 + |x|: errors of the equations are relative to it.
  virtual double state_scale(const Vector& u) const = 0;

  /// The same orbit with its nodes counted from another one or another forcing period, in the same unknowns; `tangent`, a
  /// direction at u, is moved with it. The first is u itself.
  struct Image {
    Vector u, tangent;
  };
  virtual std::vector<Image> images(const Vector& u, const Vector& tangent) const = 0;
  /// The equations of the orbit run through twice, and u in their unknowns.
  struct Doubled {
    std::unique_ptr<BranchProblem> problem;
    Vector u;
  };
  virtual Doubled doubled(const Vector& u) const = 0;
  /// The same problem, carried with steps of the numerical flows that are half as long. What changes is the error of the steps.
  virtual std::unique_ptr<BranchProblem> with_half_steps() const = 0;
  /// Second half of an orbit minus the first, in its unknowns: zero where it has half the period. Empty where it cannot have.
  virtual Vector half_difference(const Vector& u) const = 0;

  /// Lengths and tolerances are those of states of order one: states much larger than that, as those of the orbit at u, are
  /// measured in fiftieths of their size. To be set before the branch through u is followed.
  void measure_by(const Vector& u) { size_ = std::max(1.0, 0.02 * state_scale(u)); }

  /// The states that keep their values along the motions next to the orbit at u while others are held: the row of the Jacobian
  /// of each stretch is exactly that of x_j - x_{j+1}.
  virtual std::vector<PinnedState> kept_states(const Vector& u) const = 0;
  /// To be set before the branch through an orbit is followed.
  void pin(std::vector<PinnedState> states) { pinned_ = std::move(states); }
  const std::vector<PinnedState>& pinned() const { return pinned_; }

  /// Dimensionless time carried so far: the measure of cost.
  virtual double time_carried() const = 0;

  double value(const Vector& u) const { return u[u.size() - 1]; }
  /// Direction in which only the parameter changes.
  Vector parameter_direction() const { return Vector::Unit(unknowns(), unknowns() - 1); }

 protected:
  /// Factor of the tolerance that halves the steps of the general integrator, by its order.
  static constexpr double half_steps = 1.0 / 256.0;
  /// How the unknowns and the equations are ordered: node j has the unknowns j block + before + (0 ... states - 1), and the
  /// stretch after it the equations j block + (0 ... states - 1).
  struct Layout {
    Eigen::Index nodes = 0, states = 0, block = 0, before = 0;
  };
  virtual Layout layout() const = 0;

  /// See kept_states(), with the Jacobian at u.
  std::vector<PinnedState> kept_states(const Vector& u, const Matrix& jacobian) const {
    const Layout at = layout();
    std::vector<PinnedState> list;
    for (Eigen::Index i = 0; i < at.states; ++i) {
      bool kept = true;
      for (Eigen::Index j = 0; j < at.nodes && kept; ++j) {
        Eigen::RowVectorXd alone = Eigen::RowVectorXd::Zero(jacobian.cols());
        alone[j * at.block + at.before + i] += 1.0;
        alone[(j + 1) % at.nodes * at.block + at.before + i] -= 1.0;
        kept = jacobian.row(j * at.block + i) == alone;
      }
      if (kept) list.push_back({i, u[at.before + i]});
    }
    return list;
  }
  Eigen::Index closing_row(const PinnedState& pin) const {
    const Layout at = layout();
    return (at.nodes - 1) * at.block + pin.state;
  }
  /// Replaces the closing equations of the pinned states.
  void pin_residual(const Vector& u, Vector& residual) const {
    for (const PinnedState& pin : pinned_) residual[closing_row(pin)] = u[layout().before + pin.state] - pin.value;
  }
  template <class AnyMatrix> void pin_rows(AnyMatrix& jacobian) const {
    for (const PinnedState& pin : pinned_) {
      jacobian.row(closing_row(pin)).setZero();
      jacobian(closing_row(pin), layout().before + pin.state) = 1.0;
    }
  }
  /// A left vector without the rows of the pinned states, which do not depend on u.
  Eigen::VectorXcd without_pinned_rows(Eigen::VectorXcd left) const {
    for (const PinnedState& pin : pinned_) left[closing_row(pin)] = 0.0;
    return left;
  }

  double size_ = 1.0;                ///< see measure_by
  std::vector<PinnedState> pinned_;  ///< see pin
};

/// A value that the corrector's rounding has carried just beyond the range of a parameter is put back onto its end.
double within_range(const ParameterInfo& parameter, double value);

}  // namespace graze
