// SPDX-License-Identifier: GPL-3.0-or-later
// OrbitProblem: periodic orbits in free parameters, in states at fixed phases. The unknowns are u = (x_0, ..., x_{N-1} [, D],
// values) with N nodes, for an autonomous system the duration D, and the values of the free parameters. H are the shooting
// equations (ShootingEquations).
//
// All bifurcations of multipliers are conditions on the cyclic matrix (n N x n N for n states)
//     K(sigma) v = (Phi_j v_j - v_{j+1}, j < N - 1;  Phi_{N-1} v_{N-1} - sigma v_0),
// with Phi_j the transition matrix of stretch j. K is singular if sigma is a multiplier.
#pragma once

#include <graze/continuation/problems/branch_problem.hpp>
#include <graze/floquet/orbit/shooting.hpp>

#include <optional>

namespace graze {

class OrbitProblem : public BranchProblem {
 public:
  /// `p`: all parameters; those of the free ones are replaced by their values in u. `period`, `nodes`: as in ShootingEquations.
  /// `free`: the free parameters. `section_phase`: forcing phase of the first node over 2 pi. @throws std::invalid_argument as
  /// BranchProblem and ShootingEquations do.
  OrbitProblem(const SharedSystem& system, const Vector& p, int period, int nodes, std::vector<FreeParameter> free,
               const FlowOptions& options = {}, double section_phase = 0.0);
  /// With one free parameter.
  OrbitProblem(const SharedSystem& system, const Vector& p, int period, int nodes, std::size_t parameter, double scale,
               const FlowOptions& options = {}, double section_phase = 0.0);

  /// The same problem with its first node at another forcing phase, and the conversion of an orbit u of this problem to that
  /// one. nullopt if the motion cannot be carried to the new nodes.
  OrbitProblem with_section(double section_phase) const;
  /// The orbit with its nodes a time `ahead` later along it. nullopt if the motion cannot be carried there.
  std::optional<Vector> carried_on(const Vector& u, double ahead);
  std::optional<Vector> to_section(OrbitProblem& other, const Vector& u);

  /// See with_half_steps().
  OrbitProblem in_half_steps() const;

  /// The same problem with `times` as many nodes, and the conversion of an orbit u of this problem to that one. nullopt if the
  /// motion cannot be carried to the new nodes.
  OrbitProblem with_nodes(int times) const;
  std::optional<Vector> to_nodes(OrbitProblem& finer, const Vector& u);

  /// The problem of the orbits of `times` times this period, with as many times the nodes, and the conversion of an orbit u of
  /// this problem to that one: the orbit traversed `times` times. @throws std::invalid_argument for times < 1.
  OrbitProblem repeated(int times) const;
  Vector repeat(const Vector& u, int times) const;

  Eigen::Index unknowns() const override { return equations_.unknowns() + std::ssize(free_); }
  int period() const { return equations_.period(); }
  int nodes() const { return equations_.nodes(); }
  int states() const { return equations_.states(); }
  ShootingEquations& equations() { return equations_; }

  /// The unknowns u from their parts: nodes, duration, and the values of the free parameters, or the value of the only one.
  /// @throws std::invalid_argument for the wrong number of nodes or values.
  Vector pack(const std::vector<Vector>& nodes, double duration, const Vector& values) const;
  Vector pack(const std::vector<Vector>& nodes, double duration, double value) const {
    return pack(nodes, duration, Vector::Constant(1, value));
  }
  /// Sets the parameters and evaluates the stretches. False if that is not possible; failure() gives the reason.
  bool evaluate(const Vector& u, const TransitionOptions& options);
  /// H(u) and, unless null, its Jacobian (orbit_unknowns() rows, unknowns() columns). False as for evaluate(), or if an entry is
  /// not finite.
  bool residual(const Vector& u, Vector& residual, Matrix* jacobian);
  ZeroProblem zero_problem() override;
  /// The reason why the last evaluation failed, as text.
  std::string failure() const;

  PeriodicOrbit orbit(const Vector& u, const std::optional<NewtonReport>& report = {}) override;
  BranchPoint branch_point(const Vector& u, double arclength) override;
  double time_carried() const override { return equations_.time_carried(); }
  OrbitProblem& stroboscopic(const Vector& u, Vector& out) override {
    out = u;
    return *this;
  }

  /// K from the stretches of the last evaluation, which must have had the sensitivity to the state.
  Eigen::MatrixXcd cyclic(const Vector& u, std::complex<double> sigma) override;
  Eigen::VectorXcd cyclic_derivative(const Vector& u, std::complex<double> sigma, const Eigen::VectorXcd& left,
                                     const Eigen::VectorXcd& v) override;
  std::vector<PinnedState> kept_states(const Vector& u) const override;
  double state_scale(const Vector& u) const override { return 1.0 + orbit_part(u).lpNorm<Eigen::Infinity>(); }
  std::vector<Image> images(const Vector& u, const Vector& tangent) const override;
  Doubled doubled(const Vector& u) const override;
  std::unique_ptr<BranchProblem> with_half_steps() const override { return std::make_unique<OrbitProblem>(in_half_steps()); }
  Vector half_difference(const Vector& u) const override;

 private:
  Layout layout() const override { return {nodes(), states(), states(), 0}; }

  ShootingEquations equations_;
};

/// The small record of an orbit that a branch keeps, without its shape.
BranchPoint to_branch_point(const PeriodicOrbit& orbit, double value, double arclength);

}  // namespace graze
