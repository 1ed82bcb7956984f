// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeps against branches: a stable orbit that a sweep has settled on must lie on a branch of a complete skeleton. The two come
// from different computations, simulation and continuation: each checks the other.
#pragma once

#include <graze/continuation/problems/branch.hpp>
#include <graze/floquet/follow/sweep.hpp>

#include <cstddef>
#include <vector>

namespace graze {

struct OffBranches {
  std::size_t compared = 0;       ///< periodic rows up to the longest period
  std::size_t longer = 0;         ///< periodic rows of longer periods, which no branch is expected to have
  std::vector<std::size_t> rows;  ///< indices of those compared that lie on none of the branches
};

/// `longest_period`: up to which orbits were followed. `threads` does not change the result.
OffBranches off_branches(const HybridSystem& system, const std::vector<Branch>& branches, const std::vector<SweepRow>& rows,
                         int longest_period, int threads = 1);

}  // namespace graze
