// SPDX-License-Identifier: GPL-3.0-or-later
// Same points: special points that several branches have in common, such as a grazing on which one ends that begins on another,
// or two end. They are the same orbit at the same value of the parameter, whatever the branches call it.
#pragma once

#include <graze/apps/text/json.hpp>

#include <graze/continuation/problems/branch.hpp>

#include <map>
#include <utility>
#include <vector>

namespace graze::apps {

/// A special point and the branch that has it.
struct PointOfBranch {
  const Branch* branch = nullptr;
  const SpecialPoint* point = nullptr;
};

/// Of each special point that an earlier branch has, too: that of the first such branch.
using SamePoints = std::map<const SpecialPoint*, PointOfBranch>;
SamePoints same_points(const std::vector<Branch>& branches);

/// Adds "same_as": {"branch": 1, "label": "GR1"} to them, in the list of branches as json_of() writes them.
void put_same_points(Json& list, const std::vector<Branch>& branches);

}  // namespace graze::apps
