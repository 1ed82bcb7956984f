// SPDX-License-Identifier: GPL-3.0-or-later
// SignatureProblem: orbits with hard impacts in one parameter, in the coordinates of SignatureEquations: smooth up to a grazing
// and through it.
#pragma once

#include <graze/continuation/problems/branch_problem.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>
#include <graze/floquet/orbit/signature_equations.hpp>

#include <memory>
#include <optional>

namespace graze {

/// Events of an orbit in order, with their instants and the states before them.
struct EventNodes {
  std::vector<std::size_t> sequence;
  std::vector<double> times;
  std::vector<Vector> states;
  std::size_t insert(std::size_t event, double t, const Vector& x);  ///< in its place in time, which is returned
  /// To those of one turn, of an orbit run through so often: by their number, for an impact at phase 0 may stand at either end.
  void shorten(int turns);
  void repeat(int turns, double duration);  ///< that many times, each as long
};

/// Of an orbit, from phase 0 on; nullopt where it has no events, or where it sticks (accumulation points are no nodes).
std::optional<EventNodes> event_nodes(const PeriodicOrbit& orbit);

class SignatureProblem : public BranchProblem {
 public:
  SignatureProblem(const HybridSystem& system, const Vector& p, int period, std::vector<std::size_t> sequence,
                   std::size_t parameter, double scale, const FlowOptions& options = {});

  Eigen::Index unknowns() const override { return equations_.unknowns() + 1; }
  ZeroProblem zero_problem() override;
  BranchPoint branch_point(const Vector& u, double arclength) override;
  PeriodicOrbit orbit(const Vector& u, NewtonReport report) override;
  OrbitProblem& stroboscopic(const Vector& u, Vector& out) override;
  /// The orbit at u in states at other phases: `per_period` to the forcing period, from `section` on (see ShootingEquations).
  OrbitProblem in_states(const Vector& u, int per_period, double section, Vector& out);
  double time_carried() const override;
  Eigen::MatrixXcd cyclic(const Vector& u, std::complex<double> sigma) override;
  Eigen::VectorXcd cyclic_derivative(const Vector& u, std::complex<double> sigma, const Eigen::VectorXcd& w,
                                     const Eigen::VectorXcd& v) override;
  bool is_motion(const Vector& u) override { return !violation(u); }
  std::optional<std::vector<std::size_t>> sequence() const override { return equations_.sequence(); }
  std::vector<PinnedState> kept_states(const Vector& u) const override;
  double state_scale(const Vector& u) const override;
  std::vector<Image> images(const Vector& u, const Vector& tangent) const override;
  Doubled doubled(const Vector& u) const override;
  std::unique_ptr<BranchProblem> with_half_steps() const override;
  Vector half_difference(const Vector& u) const override;

  Vector pack(const EventNodes& nodes, double value) const;
  EventNodes unpack(const Vector& u) const;
  /// See SignatureEquations; the parameter is set first.
  std::optional<SignatureEquations::Violation> violation(const Vector& u);
  double least_speed(const Vector& u);
  double speed(const Vector& u, int event);
  Vector speed_gradient(const Vector& u, int event);
  double event_time(const Vector& u, int event) const { return equations_.time(u, event); }
  const SignatureEquations& equations() const { return equations_; }
  const FlowOptions& flow_options() const { return options_; }

 private:
  Layout layout() const override { return {equations_.events(), equations_.states(), equations_.states() + 1, 1}; }
  bool set_value(const Vector& u);
  double clear_section(const Vector& u) const;
  std::vector<Vector> states_at(const Vector& u, const std::vector<double>& times);

  SignatureEquations equations_;
  Vector p_;
  std::size_t parameter_;
  double scale_;
  FlowOptions options_;
  std::string failure_;
  std::unique_ptr<OrbitProblem> stroboscopic_;
  double carried_elsewhere_ = 0.0;  ///< by those that stroboscopic_ has been before
};

}  // namespace graze
