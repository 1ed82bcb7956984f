// SPDX-License-Identifier: GPL-3.0-or-later
// CubicFlow: x'' = A cos(w t) + c - 2 b v - k x - beta x^3 (dimensionless) by Taylor series of order 16 in time, with
//     dx' = dv,   dv' = -2 b dv - (k + 3 beta x^2) dx + f_p
// for the columns of Phi and Psi (cubic_recurrence.hpp); divergence = -2 b (t1 - t0). A step is as long as the last two terms
// of the series allow within FlowOptions::tolerance. If the motion escapes to infinity (beta < 0), the segment fails.
//
// No crossing of a barrier is missed: on every step the polynomial of the motion is bounded, not sampled. The Bernstein
// coefficients of its part up to degree 5, with M6 h^6 for the rest (M6 from the moduli of the coefficients), show how far the
// motion goes without a crossing. Where the speed certainly keeps its sign, the root is unique, and found by Halley's method.
#pragma once

#include <graze/lib/flow/flow.hpp>
#include <graze/lib/flow/level_barriers.hpp>
#include <graze/lib/flow/sources.hpp>

namespace graze {

class CubicFlow {
 public:
  CubicFlow(const HybridSystem& system, std::size_t mode, const Vector& p, std::span<const std::size_t> active,
            const CubicOscillator& oscillator, const FlowOptions& options);

  /// Whether all guards of the mode are levels of x.
  static bool applies(const HybridSystem& system, std::size_t mode);

  void carry(const FlowTask& task, const Vector& x0, Segment& out) const;
  void field(double t, const Vector& x, Vector& out) const;

 private:
  /// Carries with the columns of the tangent of detail::CubicState: Phi, then Psi in the coefficients of sources_.
  template <std::size_t Quads> void carry_with(const FlowTask& task, const Vector& x0, Segment& out) const;

  CubicOscillator oscillator_;
  FlowOptions options_;
  detail::Sources sources_;
  std::vector<detail::LevelBarrier> barriers_;
};

}  // namespace graze
