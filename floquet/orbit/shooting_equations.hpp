// SPDX-License-Identifier: GPL-3.0-or-later
// ShootingEquations: an orbit as the root of a system of equations. Its duration is divided into N equal stretches with nodes
// x_0 ... x_{N-1}:
//     forced:      phi(x_j; t_j, t_{j+1}) - x_{j+1} = 0, j = 0 ... N-1, x_N = x_0, t_j = (s + j n / N) T   (N n equations),
//     autonomous:  the same with the unknown duration D, t_j = j D / N, and the phase condition f(x_ref) . (x_0 - x_ref) = 0.
// Unknowns u = (x_0, ..., x_{N-1} [, D]). N = n periods is multiple shooting at forcing phase 0; N = 1 is single shooting. The
// derivatives in free parameters are the last columns of the Jacobian; they include those of the period, f dT/dp.
#pragma once

#include <graze/lib/motion/transition.hpp>

#include <map>

namespace graze {

class ShootingEquations {
 public:
  /// `period`: n forcing periods. For an autonomous orbit n turns that share its duration, such as two after a period doubling.
  /// `nodes`: N, a multiple or divisor of n (0: N = n). `free`: indices of the free parameters. `section_phase`: s in
  /// [0, 1), forcing phase of the first node over 2 pi. No node may lie at a hard impact, across which the state at a fixed
  /// phase jumps.
  ShootingEquations(const SharedSystem& system, const Vector& p, int period, int nodes = 0,
                    const std::vector<std::size_t>& free = {}, const FlowOptions& options = {}, double section_phase = 0.0);

  int states() const { return n_; }
  int nodes() const { return nodes_; }
  int period() const { return period_; }
  double section_phase() const { return section_phase_; }
  int unknowns() const { return n_ * nodes_ + (autonomous() ? 1 : 0); }
  bool autonomous() const { return !is_forced(propagator_.system()); }
  const HybridSystem& system() const { return propagator_.system(); }
  const Vector& parameters() const { return propagator_.parameters(); }
  const std::vector<std::size_t>& free() const { return free_; }
  const FlowOptions& options() const { return propagator_.options(); }
  Propagator& propagator() { return propagator_; }

  void set_parameters(const Vector& p) { propagator_.set_parameters(p); }
  /// Phase condition of an autonomous orbit: the plane through x_ref, normal to the field there.
  void set_phase_reference(const Vector& x_ref);
  bool has_phase_reference() const { return phase_reference_.size() > 0; }
  void copy_phase_condition(const ShootingEquations& other) {
    phase_reference_ = other.phase_reference_;
    phase_normal_ = other.phase_normal_;
  }

  /// Leaves out a contact of stretch j (see LeftOutContact), at most one per stretch; j = -1: all contacts are kept again.
  void leave_out(int j, const LeftOutContact& contact = {}) {
    if (j < 0) return left_out_.clear();
    left_out_[j] = contact;
  }

  /// The options with the contact left out on stretch j.
  TransitionOptions options_of_stretch(int j, TransitionOptions options) const {
    if (const auto contact = left_out_.find(j); contact != left_out_.end()) options.left_out = contact->second;
    return options;
  }

  double duration(const Vector& u) const;
  /// Start of stretch j; for forced systems modulo the forcing period.
  double node_time(const Vector& u, int j) const;
  /// The same without the modulus: time since phase 0 of the orbit.
  double orbit_time(const Vector& u, int j) const;
  Vector node(const Vector& u, int j) const { return u.segment(j * n_, n_); }

  /// Evaluates all stretches at u. False if one of them fails; `failure()` then gives the reason.
  bool evaluate(const Vector& u, const TransitionOptions& options);
  Termination failure() const { return failure_; }

  /// After evaluate: residual (unknowns()), Jacobian (unknowns() x unknowns() + free parameters), map of stretch j, and its
  /// derivatives in the free parameters (n x their number), including those of its start and end times.
  void residual(const Vector& u, Vector& out) const;
  void jacobian(Matrix& out) const;
  const Transition& stretch(int j) const { return stretches_[static_cast<std::size_t>(j)]; }
  Matrix stretch_dp(int j) const;
  /// Derivatives in the free parameters of a state on stretch j at a fixed time: Psi, corrected for the moving start of the
  /// stretch.
  Matrix fixed_time_dp(int j, const Matrix& Phi, const Matrix& Psi) const;
  /// f at the start of stretch j, and at its end.
  const Vector& start_field(int j) const { return start_fields_[static_cast<std::size_t>(j)]; }
  const Vector& end_field(int j) const { return end_fields_[static_cast<std::size_t>(j)]; }
  /// Dimensionless time carried so far, as a measure of cost.
  double time_carried() const { return propagator_.time_carried(); }

 private:
  double node_fraction(int j) const { return section_phase_ + static_cast<double>(j * period_ % nodes_) / nodes_; }

  Propagator propagator_;
  int n_ = 0, nodes_ = 0, period_ = 0;
  double section_phase_ = 0.0;
  std::vector<std::size_t> free_;
  Vector phase_reference_, phase_normal_;
  std::vector<Transition> stretches_;
  std::vector<Vector> start_fields_, end_fields_;
  std::vector<std::optional<std::size_t>> held_modes_;  ///< TransitionOptions::held_mode: the mode at a node, last time
  std::map<int, LeftOutContact> left_out_;              ///< by stretch
  Termination failure_ = Termination::failed;
};

}  // namespace graze
