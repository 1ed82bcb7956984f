// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of a skeleton as a whole: as JSON ("search", "seeds", "branches", "cascades",
// "cut_off"), and as text.
#pragma once

#include <graze/apps/problem/head.hpp>
#include <graze/apps/text/column.hpp>

#include <graze/continuation/graph/skeleton.hpp>

#include <array>
#include <string>
#include <vector>

namespace graze::apps {

/// What a skeleton puts into a result.
inline constexpr std::array skeleton_keys = {"search", "seeds", "branches", "cascades", "cut_off"};

const Columns<SearchFineness>& fineness_columns();
const Columns<CutOff>& cut_off_columns();
Columns<SkeletonSeed> seed_columns(std::size_t parameter);  ///< its index
template <> struct JsonForm<CutOff> : RecordForm<CutOff, cut_off_columns> {};

/// The schema of what it can add to a result; branches and cascades are always there.
Json skeleton_schema();

/// Adds these to the result, made on so many threads; `parameter`: index of the continuation parameter. To one that was
/// interrupted it adds "seed_search", the "parts" of it that are "done", and the "part" of each seed, so that these are not
/// searched again.
void put_skeleton(Json& result, const Skeleton& found, std::size_t parameter, int threads);

struct SeedsSoFar {
  std::vector<SkeletonSeed> seeds;
  std::vector<char> searched;  ///< as in Skeleton
};

/// The seeds of a skeleton that was interrupted, and how far the search for them was. @throws Json::exception, std::out_of_range
/// or std::invalid_argument where something is missing or damaged.
SeedsSoFar seeds_from(const Json& result, const Problem& problem, const std::string& parameter);

/// How fine the search was (as put_skeleton puts it), branches, special points, cascades, and what was not followed.
std::string skeleton_text(const Json& search, std::size_t seeds, const std::vector<Branch>& branches,
                          const std::vector<CutOff>& cut_off, const std::string& parameter);

}  // namespace graze::apps
