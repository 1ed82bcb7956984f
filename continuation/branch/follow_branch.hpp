// SPDX-License-Identifier: GPL-3.0-or-later
// Follows one branch from its start to its end, and says why it ended there.
//
// Orbits with hard impacts are followed in the coordinates of their signature (SignatureFollower), all others in their states at
// fixed phases (StatesFollower). A branch may change from the first to the second where the coordinates of the events end.
#pragma once

#include <graze/continuation/branch/branch_record.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

#include <optional>

namespace graze {

/// Follows the branch from `start` and writes it to `branch`, whose parent, period and parameters are set. Special points get no
/// labels here. Returns the grazing on which the branch ended, if any.
std::optional<GrazingEnd> follow_branch(const FollowSettings& settings, OrbitProblem& problem, const BranchStart& start,
                                        Branch& branch);

}  // namespace graze
