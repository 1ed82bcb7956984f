// SPDX-License-Identifier: GPL-3.0-or-later
// Published special points, and multipliers printed next to them, beside those located on the branch.
#pragma once

#include <graze/apps/published/comparison.hpp>
#include <graze/apps/published/published.hpp>

#include <functional>
#include <vector>

namespace graze::apps {

/// One row for the point, and one for its multipliers if there are any printed. @throws std::invalid_argument for a type or a
/// system that is not there.
std::vector<Comparison> compare_point(const Published& published, const PublishedPoint& item,
                                      const std::function<bool()>& cancelled = {});

}  // namespace graze::apps
