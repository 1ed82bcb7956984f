// SPDX-License-Identifier: GPL-3.0-or-later
// Same points: special points shared by several branches, such as a grazing at which one branch ends and another begins, or two
// end. They are the same orbit at the same parameter value, although the branches label them differently.
#pragma once

#include <graze/apps/text/json.hpp>

#include <graze/continuation/problems/branch.hpp>

#include <map>
#include <utility>
#include <vector>

namespace graze::apps {

/// A special point and the branch that contains it.
struct PointOfBranch {
  const Branch* branch = nullptr;
  const SpecialPoint* point = nullptr;
};

/// For each special point that an earlier branch also has: the point of the first such branch.
using SamePoints = std::map<const SpecialPoint*, PointOfBranch>;
SamePoints same_points(const std::vector<Branch>& branches);

/// Adds "same_as": {"branch": 1, "label": "GR1"} to these points, in the JSON list of branches from json_of().
void put_same_points(Json& list, const std::vector<Branch>& branches);

}  // namespace graze::apps
