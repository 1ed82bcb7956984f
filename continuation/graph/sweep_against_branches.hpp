// SPDX-License-Identifier: GPL-3.0-or-later
// Sweeps against branches: a stable orbit on which a sweep has settled must lie on a branch of a complete skeleton. Simulation
// and continuation are independent computations: each checks the other.
#pragma once

#include <graze/continuation/problems/branch.hpp>
#include <graze/floquet/follow/sweep.hpp>

#include <cstddef>
#include <vector>

namespace graze {

struct SweepComparison {
  std::size_t compared = 0;       ///< number of periodic rows up to the longest period
  std::size_t longer = 0;         ///< number of periodic rows of longer period, which no branch is expected to contain
  std::vector<std::size_t> rows;  ///< indices of the compared rows that lie on no branch
};

/// Compares the periodic rows of a sweep with the branches. `longest_period`: longest period that was followed. `threads` does
/// not change the result.
SweepComparison compare_sweep_with_branches(const HybridSystem& system, const std::vector<Branch>& branches,
                                            const std::vector<SweepRow>& rows, int longest_period, int threads = 1);

}  // namespace graze
