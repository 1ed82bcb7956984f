// SPDX-License-Identifier: GPL-3.0-or-later
// GeneralFlow: any smooth mode, by GSL's Prince-Dormand pair rk8pd with step control; the variational equations
//     dPhi/dt = f_x Phi,   dPsi/dt = f_x Psi + f_p,   d(divergence)/dt = trace f_x
// are integrated along with the state.
//
// Events: on every step each guard is bounded by the Bernstein coefficients of its cubic Hermite polynomial. Where that comes
// near zero, the polynomial is compared with the motion itself (a partial step of the same method), on intervals that are
// halved until both agree. Maxima and roots are then found on the motion, by Brent's method. No event between two steps is thus
// missed, as long as a step (at most a sixteenth of the forcing period) resolves the guard.
#pragma once

#include <graze/lib/flow/flow.hpp>

namespace graze {

class GeneralFlow {
 public:
  GeneralFlow(const SharedSystem& system, std::size_t mode, const Vector& p, std::span<const std::size_t> active,
              const FlowOptions& options);
  GeneralFlow(GeneralFlow&&) noexcept;
  GeneralFlow& operator=(GeneralFlow&&) noexcept;
  ~GeneralFlow();

  void carry(const FlowTask& task, const Vector& x0, Segment& out);
  void field(double t, const Vector& x, Vector& out) const;

 private:
  struct Integrator;
  std::unique_ptr<Integrator> integrator_;
};

}  // namespace graze
