// SPDX-License-Identifier: GPL-3.0-or-later
// BranchFollower: follows one branch from its start to its end, and says why it ended there.
//
// Orbits with hard impacts are followed in the coordinates of their signature (SignatureFollower), all others in their states at
// fixed phases (StatesFollower). A branch may change from the first to the second where the coordinates of the events end.
#pragma once

#include <graze/continuation/branch/branch_record.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

#include <optional>

namespace graze {

class BranchFollower {
 public:
  /// `low`, `high`: the range of the parameter. Refers to system and options.
  BranchFollower(const HybridSystem& system, const ContinuationOptions& options, double low, double high)
      : settings_(system, options, low, high) {}
  BranchFollower(HybridSystem&&, const ContinuationOptions&, double, double) = delete;

  /// Follows the branch from `start` and writes it to `branch`, whose parent, period and parameters are set. Special points get
  /// no labels here. Returns the grazing on which the branch ended, if any.
  std::optional<GrazingEnd> follow(OrbitProblem& problem, const BranchStart& start, Branch& branch) const;

 private:
  FollowSettings settings_;
};

}  // namespace graze
