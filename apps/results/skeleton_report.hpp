// SPDX-License-Identifier: GPL-3.0-or-later
// Report of a whole skeleton: as JSON ("search", "seeds", "branches", "cascades", "cut_off"), and as text.
#pragma once

#include <graze/apps/problem/head.hpp>
#include <graze/apps/text/column.hpp>

#include <graze/continuation/graph/skeleton.hpp>

#include <array>
#include <string>
#include <vector>

namespace graze::apps {

/// The members that a skeleton adds to a result.
inline constexpr std::array skeleton_keys = {"search", "seeds", "branches", "cascades", "cut_off"};

const Columns<SearchFineness>& fineness_columns();
const Columns<CutOff>& cut_off_columns();
Columns<SkeletonSeed> seed_columns(std::size_t parameter);  ///< `parameter`: index of the continuation parameter
template <> struct JsonForm<CutOff> : RecordForm<CutOff, cut_off_columns> {};

/// The schema of these members; branches and cascades are always present.
Json skeleton_schema();

/// Adds the skeleton's members to the result, produced on `threads` threads; `parameter`: index of the continuation parameter.
/// An interrupted result also gets "seed_search", with the number of "parts" and those that are "done", and the "part" of each
/// seed, so that finished parts are not searched again.
void put_skeleton(Json& result, const Skeleton& found, std::size_t parameter, int threads);

struct PartialSeeds {
  std::vector<SkeletonSeed> seeds;
  std::vector<char> searched;  ///< as in Skeleton
};

/// The seeds of an interrupted skeleton, and which parts of the search are done. @throws Json::exception, std::out_of_range or
/// std::invalid_argument if something is missing or damaged.
PartialSeeds seeds_from(const Json& result, const Problem& problem, const std::string& parameter);

/// The fineness of the search (as put_skeleton writes it), branches, special points, cascades, and the branches that
/// were not followed.
std::string skeleton_text(const Json& search, std::size_t seeds, const std::vector<Branch>& branches,
                          const std::vector<CutOff>& cut_off, const std::string& parameter);

}  // namespace graze::apps
