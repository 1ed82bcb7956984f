// SPDX-License-Identifier: GPL-3.0-or-later
// TrappingRegion: states at forcing phase 0 so close to a stable periodic orbit that the motion from them settles on it.
//
// Around the orbit's states c_k (k = 0 ... n - 1) an adapted metric makes every single forcing period a contraction:
//
//     V_k(x) = (x - c_k)^T H_k (x - c_k),    H_k = I + Phi_k^T H_{k+1} Phi_k / q^2,    V_{k+1}(Phi_k d) <= q^2 V_k(d),
//
// with Phi_k the transition matrix of period k and q between the orbit's own rate |mu_1|^(1/n) and 1. The region is V_k <=
// size^2 for all k. `size` is found by trial. Motions from the shells of twice, once and half that size are carried through one
// period. Each must meet the same events with a jump as the orbit (so that no hard impact grazes inside), and its distance in
// the metric must shrink to at most (1 + q) / 2 of itself. This is sampled, not proved, hence the factor of two. The region of
// an orbit at a hard grazing (size 0) consists of its own states: a motion that is bitwise in one of them stays on the orbit.
// The region of a mass at rest on its stop is that of the bounces that die out (lib/motion/rest.hpp).
#pragma once

#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/motion/transition.hpp>

#include <optional>
#include <vector>

namespace graze {

struct TrappingRegion {
  std::vector<Vector> centres;  ///< the orbit's states at forcing phase 0
  std::vector<Matrix> metrics;  ///< H_k
  double size = 0.0;            ///< bound of |x - c_k| for all states inside; 0: only the centres are inside
  double rate = 1.0;            ///< |mu_1|^(1/n): asymptotic contraction of a distance per period; 1: unknown

  /// True if x, a state at forcing phase 0, lies inside.
  bool holds(const Vector& x) const;
  /// The same for motions in lanes (of two states), or slightly larger.
  std::vector<StateEllipse> ellipses() const;
  /// Least distance from x to a centre, in the maximum norm.
  double distance(const Vector& x) const;
};

/// The region of the stable orbit of `period` forcing periods through `state` at forcing phase 0. The result is a bitwise
/// function of the arguments. An orbit that is not stable, or motions that cannot be carried out, give size 0.
TrappingRegion trapping_region(const HybridSystem& system, const Vector& p, const Vector& state, int period,
                               const FlowOptions& flow = {});

}  // namespace graze
