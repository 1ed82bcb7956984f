// SPDX-License-Identifier: GPL-3.0-or-later
// Published special points, and multipliers printed next to them, beside those located on the branch.
#pragma once

#include <graze/apps/published/comparison.hpp>
#include <graze/apps/published/published.hpp>

#include <functional>
#include <vector>

namespace graze::apps {

/// One row for the point, and one for its multipliers if any are printed. @throws std::invalid_argument for an unknown type or
/// system.
std::vector<Comparison> compare_point(const Published& published, const PublishedPoint& item,
                                      const std::function<bool()>& cancelled = {});

}  // namespace graze::apps
