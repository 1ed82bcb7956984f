// SPDX-License-Identifier: GPL-3.0-or-later
// TrappingRegion: states at forcing phase 0 so near to a stable periodic orbit that the motion from them is sure to settle on it.
//
// Around the orbit's states c_k (k = 0 ... n - 1) an adapted metric makes every single forcing period a contraction:
//     V_k(x) = (x - c_k)^T H_k (x - c_k),    H_k = I + Phi_k^T H_{k+1} Phi_k / q^2,    V_{k+1}(Phi_k d) <= q^2 V_k(d),
// with Phi_k the transition matrix of period k and q between the orbit's own rate |mu_1|^(1/n) and 1. The region is V_k <= size^2
// for all k. `size` is found by trial: on the shells of twice, once and half that size motions are carried through one period;
// each must meet the same events with a jump as the orbit (so that no hard impact grazes inside) and must come closer by at least
// half of what is left from q to 1. Sampled, not proved, hence the factor of two. An orbit at a hard grazing has no region
// (size 0) but its own states: a motion that is in one of them to the last bit stays on the orbit. The region of a mass at rest
// on its stop is that of the bounces that die out (lib/rest.hpp).
#pragma once

#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/motion/transition.hpp>

#include <optional>
#include <vector>

namespace graze {

struct TrappingRegion {
  std::vector<Vector> centres;  ///< the orbit's states at forcing phase 0
  std::vector<Matrix> metrics;  ///< H_k
  double size = 0.0;            ///< |x - c_k| of all states inside is at most this; 0: only the centres are
  double rate = 1.0;            ///< |mu_1|^(1/n): what a period leaves of a distance in the long run; 1: it is not known

  /// True if x, a state at forcing phase 0, lies inside.
  bool holds(const Vector& x) const;
  /// The same for motions in lanes (of two states), or a little larger.
  std::vector<StateEllipse> ellipses() const;
  /// Least distance from x to a centre, in the maximum norm.
  double distance(const Vector& x) const;
};

/// Of the stable orbit of `period` forcing periods through `state` at forcing phase 0. What it is given decides the result to the
/// last bit. An orbit that is not stable, or motions that cannot be carried out, give size 0.
TrappingRegion trapping_region(const HybridSystem& system, const Vector& p, const Vector& state, int period,
                               const FlowOptions& flow = {});

}  // namespace graze
