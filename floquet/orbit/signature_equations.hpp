// SPDX-License-Identifier: GPL-3.0-or-later
// SignatureEquations: an orbit with a fixed signature as the root of a system of equations, with nodes at its events. The
// unknowns are the times of the m events and the states just before them, u = (t_1, x_1, ..., t_m, x_m); with guard h_k, reset
// g_k and the flow phi_k between events,
//
//     phi_k(g_k(t_k, x_k); t_k, t_{k+1}) - x_{k+1} = 0,    h_k(t_k, x_k) = 0,    t_{m+1} = t_1 + n T, x_{m+1} = x_1.
//
// The flows ignore the guards, so the equations are smooth through zero speed at an event. A branch of hard impacts can
// therefore be followed to its grazing (di Bernardo, Budd, Champneys & Kowalczyk 2008, section 7.2), where the state at a fixed
// phase varies like a square root. Beyond the grazing, or if a flight passes through a guard, solutions are not motions: see
// violation(). For forced systems.
#pragma once

#include <graze/floquet/orbit/multipliers.hpp>
#include <graze/lib/motion/propagator.hpp>

namespace graze {

class SignatureEquations {
 public:
  /// `events`: indices in HybridSystem::events, in order; each starts in the mode to which the one before it leads. `free`:
  /// indices of the free parameters, at least one. @throws std::invalid_argument for events that do not fit together.
  SignatureEquations(const SharedSystem& system, const Vector& p, int period, std::vector<std::size_t> events,
                     const std::vector<std::size_t>& free, const FlowOptions& options = {});

  int states() const { return n_; }
  int period() const { return period_; }
  int events() const { return static_cast<int>(sequence_.size()); }
  const std::vector<std::size_t>& sequence() const { return sequence_; }
  int unknowns() const { return (n_ + 1) * events(); }
  const HybridSystem& system() const { return propagator_.system(); }
  const Vector& parameters() const { return propagator_.parameters(); }
  void set_parameters(const Vector& p) { propagator_.set_parameters(p); }
  double duration() const { return period_ * forcing_period(system(), parameters()); }

  /// Dimensionless time carried so far, as a measure of cost.
  double time_carried() const { return propagator_.time_carried(); }

  double time(const Vector& u, int k) const { return u[k * (n_ + 1)]; }
  Vector state(const Vector& u, int k) const { return u.segment(k * (n_ + 1) + 1, n_); }

  /// The equations of event k and of the flight after it: rows of the residual, and of the Jacobian by columns.
  struct Block {
    Vector mismatch;     ///< phi_k(g_k(t_k, x_k)) - x_{k+1}
    double gap = 0.0;    ///< h_k(t_k, x_k)
    Matrix own, next;    ///< d(mismatch) by (t_k, x_k) and by (t_{k+1}, x_{k+1}), n x (n + 1)
    Vector own_gap;      ///< d(gap) by (t_k, x_k)
    Matrix mismatch_dp;  ///< by the free parameters
    Vector gap_dp;
  };
  /// False if the flow cannot be carried out, or if the next event would precede this one.
  bool evaluate(const Vector& u, int k, bool derivatives, Block& block);

  /// Residual (unknowns()) and, unless null, Jacobian (unknowns() x unknowns() + free parameters, these last). False if a flow
  /// cannot be carried out.
  bool evaluate(const Vector& u, Vector& residual, Matrix* jacobian);

  /// Whether constraints hold on all flights, and fix states at values that neither the time nor a free parameter moves. The
  /// equations then know that a disturbance off them is lost; the states themselves stay where they are.
  bool holds_states(const Vector& u);

  /// dh_k/dt just before event k: its normal speed, negative beyond grazing; and its gradient in u and the free
  /// parameters.
  double speed(const Vector& u, int k);
  Vector speed_gradient(const Vector& u, int k);
  /// The speed in units of the states: over the largest |dh_k/dx_i|. (A stop's release or a friction's guard is a force.)
  double scaled_speed(const Vector& u, int k);

  /// An event at which u is not a motion: its speed is not positive, or a guard is met on the flight after it.
  struct Violation {
    int event = 0;
    bool lost = false;                    ///< the speed is not positive; otherwise the flight after it fails
    std::optional<EventRecord> met = {};  ///< on that flight; empty if it could not be carried out
  };
  std::optional<Violation> violation(const Vector& u);

  /// Saltation and transition matrices in order, once around from just before event 1, and the Liouville check of their sum.
  MonodromyMatrix monodromy(const Vector& u, double* liouville_error = nullptr);

  /// The states at increasing times, along the flights.
  std::vector<Vector> states_at(const Vector& u, const std::vector<double>& times);
  /// Mode at time t.
  std::size_t mode_at(const Vector& u, double t) const;

 private:
  double end_time(const Vector& u, int k) const;
  int flight_at(const Vector& u, double t, double& shift) const;
  bool is_next_event(const Vector& u, int k, const EventRecord& met);
  HybridState after(const Vector& u, int k);
  const std::vector<const Constraint*>& held(int k) const { return held_[static_cast<std::size_t>(k)]; }
  bool fixes_states(const HybridState& start, int k) const;
  const Event& event(int k) const { return system().events[sequence_[static_cast<std::size_t>(k)]]; }

  Propagator propagator_;
  int n_ = 0, period_ = 0;
  std::vector<std::size_t> sequence_;
  std::vector<std::size_t> free_;
  std::vector<std::vector<const Constraint*>> held_;  ///< on the flight after each event: the constraints that hold on all
};

}  // namespace graze
