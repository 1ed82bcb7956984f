// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of a skeleton as a whole: as JSON ("seeds", "branches", "cascades", "cut_off"), and as text.
#pragma once

#include <graze/apps/json.hpp>

#include <graze/continuation/skeleton.hpp>

#include <array>
#include <string>
#include <vector>

namespace graze::apps {

/// What a skeleton puts into a result.
inline constexpr std::array skeleton_keys = {"seeds", "branches", "cascades", "cut_off"};

/// Adds these to the result; `parameter`: index of the continuation parameter.
void put_skeleton(Json& result, const Skeleton& found, std::size_t parameter);

/// "cut_off" read back. @throws Json::exception where something is missing or of another kind.
std::vector<CutOff> cut_off_from(const Json& list);

/// Branches, special points, cascades, and what was not followed, as tables.
std::string skeleton_text(std::size_t seeds, const std::vector<Branch>& branches, const std::vector<CutOff>& cut_off,
                          const std::string& parameter);

}  // namespace graze::apps
