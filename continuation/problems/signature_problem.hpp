// SPDX-License-Identifier: GPL-3.0-or-later
// SignatureProblem: periodic orbits with hard impacts in free parameters, in the coordinates of SignatureEquations: the unknowns
// are u = (t_1, x_1, ..., t_m, x_m, values), with the times of the m events, the states just before them, and the values of the
// free parameters. The equations are smooth up to a grazing and through it. For forced systems.
#pragma once

#include <graze/continuation/problems/branch_problem.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>
#include <graze/floquet/orbit/signature_equations.hpp>

#include <memory>
#include <optional>

namespace graze {

/// The events of an orbit in order, with their times (from phase 0) and the states just before them.
struct EventNodes {
  std::vector<std::size_t> sequence;
  std::vector<double> times;
  std::vector<Vector> states;
  /// Inserts an event in the order of time, and returns its index.
  std::size_t insert(std::size_t event, double t, const Vector& x);
  /// Keeps the first turn of an orbit traversed `turns` times. Events are selected by their number and not by their time,
  /// because an impact at phase 0 may be listed at either end.
  void shorten(int turns);
  /// Repeats the events: `turns` turns in total, each of this duration.
  void repeat(int turns, double duration);
};

/// The events of an orbit, from phase 0 on. nullopt if it has none, or if it sticks: an accumulation point cannot be a node.
std::optional<EventNodes> event_nodes(const PeriodicOrbit& orbit);

class SignatureProblem : public BranchProblem {
 public:
  /// `sequence`: indices of the events, in order. `free`: the free parameters. @throws std::invalid_argument as BranchProblem and
  /// SignatureEquations do.
  SignatureProblem(const SharedSystem& system, const Vector& p, int period, std::vector<std::size_t> sequence,
                   std::vector<FreeParameter> free, const FlowOptions& options = {});
  /// With one free parameter.
  SignatureProblem(const SharedSystem& system, const Vector& p, int period, std::vector<std::size_t> sequence,
                   std::size_t parameter, double scale, const FlowOptions& options = {});

  Eigen::Index unknowns() const override { return equations_.unknowns() + std::ssize(free_); }
  ZeroProblem zero_problem() override;
  BranchPoint branch_point(const Vector& u, double arclength) override;
  PeriodicOrbit orbit(const Vector& u, const std::optional<NewtonReport>& report = {}) override;
  OrbitProblem& stroboscopic(const Vector& u, Vector& out) override;
  /// The orbit at u in states at fixed phases: `per_period` nodes per forcing period, the first at phase `section` (over 2 pi).
  /// Its unknowns are written to `out`; they are NaN if a flight cannot be carried out.
  OrbitProblem in_states(const Vector& u, int per_period, double section, Vector& out);
  double time_carried() const override;
  Eigen::MatrixXcd cyclic(const Vector& u, std::complex<double> sigma) override;
  Eigen::VectorXcd cyclic_derivative(const Vector& u, std::complex<double> sigma, const Eigen::VectorXcd& left,
                                     const Eigen::VectorXcd& v) override;
  bool is_motion(const Vector& u) override { return !violation(u); }
  std::optional<std::vector<std::size_t>> sequence() const override { return equations_.sequence(); }
  std::vector<PinnedState> kept_states(const Vector& u) const override;
  double state_scale(const Vector& u) const override;
  std::vector<Image> images(const Vector& u, const Vector& tangent) const override;
  Doubled doubled(const Vector& u) const override;
  std::unique_ptr<BranchProblem> with_half_steps() const override;
  Vector half_difference(const Vector& u) const override;

  /// The unknowns u from events and the values of the free parameters (or the value of the only one), and the events from u.
  /// @throws std::invalid_argument for the wrong number of values.
  Vector pack(const EventNodes& nodes, const Vector& values) const;
  Vector pack(const EventNodes& nodes, double value) const { return pack(nodes, Vector::Constant(1, value)); }
  EventNodes unpack(const Vector& u) const;
  /// See SignatureEquations. The parameters are set to their values in u first; if the model refuses them, u counts as a
  /// violation.
  std::optional<SignatureEquations::Violation> violation(const Vector& u);
  /// Whether an event leads to another mode: a contact of several events, which may coincide.
  bool through_modes() const;
  /// Smallest scaled speed of the events; infinity if the model refuses the parameters.
  double least_speed(const Vector& u);
  /// dh/dt just before the event with this number, and its gradient in u.
  double speed(const Vector& u, int event);
  Vector speed_gradient(const Vector& u, int event);
  double event_time(const Vector& u, int event) const { return equations_.time(u, event); }
  const SignatureEquations& equations() const { return equations_; }
  const FlowOptions& flow_options() const { return options_; }

 private:
  Layout layout() const override { return {equations_.events(), equations_.states(), equations_.states() + 1, 1}; }
  bool set_value(const Vector& u) { return BranchProblem::set_value(equations_, u); }
  double clear_section(const Vector& u) const;
  std::vector<Vector> states_at(const Vector& u, const std::vector<double>& times);

  SignatureEquations equations_;
  FlowOptions options_;
  std::unique_ptr<OrbitProblem> stroboscopic_;
  double carried_elsewhere_ = 0.0;  ///< time carried by earlier values of stroboscopic_
};

}  // namespace graze
