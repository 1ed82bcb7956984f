// SPDX-License-Identifier: GPL-3.0-or-later
// BranchProblem: the periodic orbits in one or several free parameters as solutions of H(u) = 0. It hides the choice of
// coordinates: states at fixed phases (OrbitProblem), or times and states of the events of a fixed signature (SignatureProblem).
// The unknowns u are those of the orbit, then the values of the free parameters. There are as many equations as unknowns of the
// orbit: with one free parameter the solutions are curves. With two of them, one condition more selects curves, such as the
// period doublings in two parameters. Times and states are dimensionless.
//
// A program gets problems from the library, for example in TestFunction::locate, or makes an OrbitProblem. The protected part
// serves the two kinds of problems and is no interface for other classes.
#pragma once

#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/trace/zero_problem.hpp>
#include <graze/floquet/orbit/kept_state.hpp>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace graze {

class OrbitProblem;

/// A state, or the difference of two, that returns to itself after each period of the forcing for any value: the position of a
/// mass that friction holds on the ground or on a table, or the distance of two masses that friction holds together. Its closing
/// equation is then always satisfied, and orbits with any value in a band form a continuum. The branch selects the orbits with
/// the given value: the equation "it has this value at the first node" replaces the closing equation. Its multiplier +1 is
/// trivial.
struct PinnedState {
  KeptState state;
  double value = 0.0;
};

/// Unit of a parameter with values from `low` to `high`: it takes the place of 1 in 1 + |x|. It is 1 if the largest |value| is of
/// order one, from 0.1 to 10. Below it is ten times that value, above a tenth of it: then results do not depend on the unit in
/// which the parameter is given.
double parameter_unit(double low, double high);

/// A parameter whose value is an unknown.
struct FreeParameter {
  std::size_t index = 0;  ///< in HybridSystem::parameters
  double scale = 1.0;     ///< unit of its changes in the arclength (usually the range that is followed); in its own unit
  double unit = 0.0;      ///< see parameter_unit; 0: that of its scale and of its value at the start
};

class BranchProblem {
 public:
  virtual ~BranchProblem() = default;

  const SharedSystem& system() const { return system_; }
  /// The free parameters, at least one. The last unknowns are their values, in this order.
  const std::vector<FreeParameter>& free() const { return free_; }
  /// The first free parameter, in which a branch is followed: its index, and its unit in the arclength.
  std::size_t parameter() const { return free_.front().index; }
  double scale() const { return free_.front().scale; }
  double unit() const { return free_.front().unit; }
  /// Size of a value of the first free parameter. Tolerances of its values are relative to it.
  double size_of_value(double value) const { return unit() + std::abs(value); }

  /// Number of unknowns, the values of the free parameters included.
  virtual Eigen::Index unknowns() const = 0;
  /// Number of the orbit's own unknowns and of the equations, and place of the first free parameter's value in u.
  Eigen::Index orbit_unknowns() const { return unknowns() - std::ssize(free_); }
  /// H(u) = 0 in the unknowns(). The tracer needs one equation fewer than unknowns: with k free parameters, k - 1 conditions are
  /// to be added. The equations refer to this object.
  virtual ZeroProblem zero_problem() = 0;
  /// The orbit at u: the small record that a branch keeps, and the orbit with all its properties. `report`: of the Newton
  /// iteration that gave u; none: the residual at u tells whether it is an orbit.
  virtual BranchPoint branch_point(const Vector& u, double arclength) = 0;
  virtual PeriodicOrbit orbit(const Vector& u, const std::optional<NewtonReport>& report = {}) = 0;
  /// The same orbit in states at fixed phases; its unknowns are written to `out`. The reference is valid until the next call.
  virtual OrbitProblem& stroboscopic(const Vector& u, Vector& out) = 0;

  /// K(sigma) at u: the derivative of the equations in the orbit's unknowns (square, without the parameters), with the link from
  /// the last node to the first multiplied by sigma. K is singular if sigma is a multiplier. Evaluate the equations at u with
  /// their Jacobian first.
  virtual Eigen::MatrixXcd cyclic(const Vector& u, std::complex<double> sigma) = 0;
  /// left^H (dK/du_i) v for each unknown u_i (the values of the free parameters last), by central differences at u.
  virtual Eigen::VectorXcd cyclic_derivative(const Vector& u, std::complex<double> sigma, const Eigen::VectorXcd& left,
                                             const Eigen::VectorXcd& v) = 0;
  /// Whether the solution u is a motion. A solution with a fixed signature may pass through a barrier.
  virtual bool is_motion(const Vector&) { return true; }
  /// The events to which the unknowns belong, in order (indices in HybridSystem::events); nullopt for states at fixed phases.
  virtual std::optional<std::vector<std::size_t>> sequence() const { return std::nullopt; }
  /// Size of the orbit's states, 1 + |x|. Errors of the equations are relative to it.
  virtual double state_scale(const Vector& u) const = 0;

  /// Another representation of the same orbit in the same unknowns.
  struct Image {
    Vector u, tangent;
  };
  /// Representations of the orbit at u: its nodes may be counted from another node, or from another forcing period. The
  /// first is u itself. `tangent`, a direction at u, is transformed in the same way.
  virtual std::vector<Image> images(const Vector& u, const Vector& tangent) const = 0;
  /// The equations of the orbit traversed twice, and u in their unknowns.
  struct Doubled {
    std::unique_ptr<BranchProblem> problem;
    Vector u;
  };
  virtual Doubled doubled(const Vector& u) const = 0;
  /// The same problem with steps of the numerical flows half as long. The change of a result shows the error of the steps.
  virtual std::unique_ptr<BranchProblem> with_half_steps() const = 0;
  /// Second half of the orbit minus the first, in its unknowns. It is zero for an orbit of half the period. Empty if the orbit
  /// cannot have half the period (odd number of periods, nodes or events, or halves with different
  /// events).
  virtual Vector half_difference(const Vector& u) const = 0;

  /// Size of the unknown u_i: 1 + |u_i|, with the unit of a free parameter instead of 1. Steps of differences are relative to it.
  double size_of_unknown(const Vector& u, Eigen::Index i) const;
  /// The largest entry of a change of the unknowns, with the free parameters measured in their units.
  double largest_change(const Vector& change) const;

  /// Scales the arclength and the tolerances, which are set for states of order one. If the states of the orbit at u are much
  /// larger, their unit becomes a fiftieth of their size. Call this before following the branch through u.
  void measure_by(const Vector& u) { size_ = std::max(1.0, 0.02 * state_scale(u)); }

  /// The states that are kept on all motions next to the orbit at u, while constraints hold. Criterion: in the Jacobian of each
  /// stretch the row of the state is, in the states, that of x_j - x_{j+1}, and in times and parameters the rows of all stretches
  /// add up to zero. Empty if the equations cannot be evaluated.
  virtual std::vector<PinnedState> kept_states(const Vector& u) const = 0;
  /// Pins these states. Call this before following the branch through an orbit.
  void pin(std::vector<PinnedState> states) { pinned_ = std::move(states); }
  const std::vector<PinnedState>& pinned() const { return pinned_; }
  /// Pins the states that the other problem pins, at the values that they have at u: its first node may lie elsewhere.
  void pin_as(const BranchProblem& other, const Vector& u) {
    pinned_ = other.pinned_;
    const Layout at = layout();
    for (PinnedState& pin : pinned_) pin.value = pin.state.of(u.segment(at.before, at.states));
  }

  /// Dimensionless time simulated so far, as a measure of cost.
  virtual double time_carried() const = 0;

  /// The parts of u: the unknowns of the orbit, the values of the free parameters, and the value of the first one. u may also be
  /// given in other coordinates with the same free parameters.
  Eigen::VectorBlock<const Vector> orbit_part(const Vector& u) const { return u.head(u.size() - std::ssize(free_)); }
  Eigen::VectorBlock<const Vector> values(const Vector& u) const { return u.tail(std::ssize(free_)); }
  double value(const Vector& u) const { return u[u.size() - std::ssize(free_)]; }
  /// Unit vector along the value of the first free parameter.
  Vector parameter_direction() const { return Vector::Unit(unknowns(), orbit_unknowns()); }

 protected:
  /// @throws std::invalid_argument unless `free` names at least one parameter of the system, and none twice.
  BranchProblem(SharedSystem system, Vector p, std::vector<FreeParameter> free);

  /// Indices of the free parameters, for the equations.
  std::vector<std::size_t> free_indices() const;
  /// Writes the values of the free parameters to the end of u. @throws std::invalid_argument for the wrong number of values.
  void set_values(Vector& u, const Vector& values) const;
  /// Sets the weights of the free parameters' values in the arclength.
  void weigh_values(Vector& weights) const;
  /// Derivative of a function of a shift by differences of step h: central or, where the function has no value on one side (at
  /// the end of a parameter's range), to the other side. Zero if it has none on either.
  template <class Function> static std::complex<double> difference(double h, const Function& value_at) {
    const std::optional<std::complex<double>> after = value_at(h), before = value_at(-h);
    if (after && before) return (*after - *before) / (2.0 * h);
    if (!after && !before) return 0.0;
    const std::optional<std::complex<double>> here = value_at(0.0);
    if (!here) return 0.0;
    return after ? (*after - *here) / h : (*here - *before) / h;
  }
  /// The parameters of the orbit at u. A value that rounding of the corrector has carried just beyond the parameter's range is
  /// put back onto its end.
  Vector parameters_at(const Vector& u) const;
  /// Gives the equations the parameters at u. False: they refuse them and keep those before, and failure_ says why.
  template <class Equations> bool set_value(Equations& equations, const Vector& u) {
    Vector p = parameters_at(u);
    try {
      equations.set_parameters(p);
    } catch (const std::invalid_argument& refused) {
      failure_ = refused.what();
      return false;
    }
    p_ = std::move(p);
    return true;
  }
  /// Takes over the unit of length and the pinned states.
  void measure_as(const BranchProblem& other) {
    size_ = other.size_;
    pinned_ = other.pinned_;
  }

  /// Factor of the tolerance that halves the steps of the general integrator, from its order.
  static constexpr double half_steps = 1.0 / 256.0;
  /// Order of unknowns and equations: the states of node j are the unknowns j block + before + (0 ... states - 1), and the
  /// stretch after node j has the equations j block + (0 ... states - 1).
  struct Layout {
    Eigen::Index nodes = 0, states = 0, block = 0, before = 0;
  };
  virtual Layout layout() const = 0;

  /// The states found by the criterion of kept_states() in the given Jacobian at u.
  std::vector<PinnedState> kept_states(const Vector& u, const Matrix& jacobian) const;
  /// The row of the closing equation of the state: the last stretch.
  Eigen::Index closing_row(const PinnedState& pin) const {
    const Layout at = layout();
    return (at.nodes - 1) * at.block + pin.state.index;
  }
  /// Replaces the closing equations of the pinned states: in the residual, and in the Jacobian or K.
  void pin_residual(const Vector& u, Vector& residual) const {
    for (const PinnedState& pin : pinned_)
      residual[closing_row(pin)] = pin.state.of(u.segment(layout().before, layout().states)) - pin.value;
  }
  template <class AnyMatrix> void pin_rows(AnyMatrix& jacobian) const {
    for (const PinnedState& pin : pinned_) {
      jacobian.row(closing_row(pin)).setZero();
      jacobian(closing_row(pin), layout().before + pin.state.index) = 1.0;
      if (pin.state.less) jacobian(closing_row(pin), layout().before + *pin.state.less) = -1.0;
    }
  }
  /// A left vector with zeros in the rows of the pinned states. These rows of K do not depend on u.
  Eigen::VectorXcd without_pinned_rows(Eigen::VectorXcd left) const {
    for (const PinnedState& pin : pinned_) left[closing_row(pin)] = 0.0;
    return left;
  }

  SharedSystem system_;
  Vector p_;  ///< with the values set last
  std::vector<FreeParameter> free_;
  std::string failure_;              ///< of the last evaluation
  double size_ = 1.0;                ///< see measure_by
  std::vector<PinnedState> pinned_;  ///< see pin
};

/// @throws std::invalid_argument unless the problem has one free parameter: a bifurcation is a point in one parameter, and a
/// curve in two.
void require_one_parameter(const BranchProblem& problem);

/// Rounding of one evaluation of an orbit's equations, relative to 1 + |x|: ten times the measured scatter of a period's map.
inline constexpr double rounding_of_equations = 1e-14;

}  // namespace graze
