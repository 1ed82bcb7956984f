// SPDX-License-Identifier: GPL-3.0-or-later
// Reading branches back from a result (graze.branch/1), so that a run can go on from them. The inverse of branch_report.hpp as
// far as that needs it: values, states, stability and special points; no events and no monodromy matrices.
#pragma once

#include <graze/apps/text/json.hpp>

#include <graze/continuation/problems/branch.hpp>

#include <vector>

namespace graze::apps {

/// The branches of a result. @throws std::invalid_argument in one sentence if something is missing or damaged.
std::vector<Branch> branches_from_json(const Json& result);

}  // namespace graze::apps
