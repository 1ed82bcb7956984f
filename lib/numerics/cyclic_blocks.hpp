// SPDX-License-Identifier: GPL-3.0-or-later
// CyclicBlocks: solver for the linear equations of one Newton step on the shooting equations of a forced orbit with two states
// and one node per forcing period,
//     Phi_k d_k - d_{k+1} = -r_k,   k = 0 ... n - 1,   d_n = d_0,
// in time proportional to n. The nodes are eliminated one after the other by reflections (S. J. Wright, SIAM J. Sci. Stat.
// Comput. 13 (1992) 742), which stays accurate if the product of the Phi_k is large.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <array>
#include <vector>

namespace graze {

class CyclicBlocks {
 public:
  /// Computes the steps d_0 ... d_{n-1}, columns as those of r; not finite if the equations have no unique solution.
  void solve(const std::vector<Matrix>& Phi, const Matrix& r, Matrix& d);

 private:
  /// Upper rows of a node's elimination: R d_k + S d_0 + T d_{k+1} = h, as rows of 7 numbers.
  std::vector<std::array<std::array<double, 7>, 2>> rows_;
};

}  // namespace graze
