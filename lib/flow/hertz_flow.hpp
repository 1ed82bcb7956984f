// SPDX-License-Identifier: GPL-3.0-or-later
// HertzFlow: a passage through Hertz contact in regularising variables. With y = sqrt(x - r) and dt = y ds,
//     dy/ds = v/2,   dt/ds = y,   dv/ds = y (xi cos(eta t) - 2 b v - x - beta x^3 - k_H y^3 (1 + b_H v)),   x = r + y^2,
// analytic through entry and exit, which are the simple root y = 0; grazing is the equilibrium (0, 0). The tangent is carried
// in (x, v) at fixed time, dPhi/ds = y A Phi, dPsi/ds = y (A Psi + f_p), which is regular there. Steps are Taylor series of
// order 16 (hertz_recurrence.hpp), which also give the roots. A step is at most a fraction of the shortest possible contact,
// pi sqrt(2/|a|) in s, so that no contact is stepped over.
#pragma once

#include <graze/lib/flow/flow.hpp>
#include <graze/lib/flow/sources.hpp>

namespace graze {

namespace detail {
template <std::size_t Quads> struct HertzState;
}

class HertzFlow {
 public:
  HertzFlow(const HybridSystem& system, std::size_t mode, std::span<const std::size_t> active, const HertzContact& contact,
            const FlowOptions& options);

  /// Whether the mode's only event is leaving through x = r, a parameter.
  static bool applies(const HybridSystem& system, std::size_t mode, const HertzContact& contact);

  void carry(const FlowTask& task, const Vector& x0, Segment& out) const;
  void field(double t, const Vector& x, Vector& out) const;

 private:
  /// Carries with the columns of the tangent of detail::HertzState.
  template <std::size_t Quads> void carry_with(const FlowTask& task, const Vector& x0, Segment& out) const;
  template <std::size_t Quads> void start_from_rest(const FlowTask& task, double dt, detail::HertzState<Quads>& z) const;
  /// -d(acceleration)/dv at depth y^2.
  double speed_coefficient(double y) const;

  HertzContact contact_;
  FlowOptions options_;
  std::size_t leave_ = 0;  // the event
  detail::Sources sources_;
};

}  // namespace graze
