// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of branches and special points: as JSON (graze.branch/1, graze.point/1), as text, as table rows.
#pragma once

#include <graze/apps/problem/problem.hpp>
#include <graze/apps/quantities/quantities.hpp>
#include <graze/apps/results/same_points.hpp>
#include <graze/apps/text/json.hpp>
#include <graze/apps/text/table.hpp>

#include <graze/continuation/problems/branch.hpp>

#include <optional>
#include <string>
#include <vector>

namespace graze::apps {

/// Quantities at the points of a branch, in their order; empty: none.
struct BranchQuantities {
  std::vector<QuantityValues> points, special_points;
};

/// Measures the quantities on all points of these branches, on `threads` threads. Empty if there are no quantities.
std::vector<BranchQuantities> measure(const Quantities& quantities, const HybridSystem& system,
                                      const std::vector<Branch>& branches, int threads);

/// Adds them to the points of branches, as branch_json() writes these, or takes them away.
void put_quantities(Json& list, const std::vector<BranchQuantities>& measured);

Json special_point_json(const SpecialPoint& point);
Json branch_json(const Branch& branch);

/// A special point with twelve digits: where, how well known, its orbit and its details.
std::string special_point_text(const SpecialPoint& point, const std::string& parameter);

/// Whether the orbit at the point is stable, which is not for its multipliers to say everywhere.
std::string stability_text(const SpecialPoint& point);

/// "yes", "no", or empty where that is not told: in a table.
std::string stable_cell(std::optional<bool> stable);

/// A branch: a table of its points (thinned out to `most` rows), its special points, and why it stopped. Of special points that
/// an earlier branch has, too, it is said which they are.
std::string branch_text(const Problem& problem, const Branch& branch, std::size_t most, const SamePoints& same,
                        const BranchQuantities& measured = {});

/// One row per point of each branch, special points in their places with their labels.
Table branches_table(const Problem& problem, const std::vector<Branch>& branches,
                     const std::vector<BranchQuantities>& measured = {});

}  // namespace graze::apps
