// SPDX-License-Identifier: GPL-3.0-or-later
// Helpers for tests of branches.
#pragma once

#include <graze/continuation/graph/continuation.hpp>

#include <algorithm>
#include <string>
#include <vector>

namespace graze::support {

inline std::vector<SpecialPoint> points_of(const Branch& branch, PointType type) {
  std::vector<SpecialPoint> list;
  std::copy_if(branch.special_points.begin(), branch.special_points.end(), std::back_inserter(list),
               [&](const SpecialPoint& point) { return point.type == type; });
  return list;
}

/// The branches born at a special point.
inline std::vector<const Branch*> born_at(const SpecialPoint& point, const std::vector<Branch>& branches) {
  std::vector<const Branch*> list;
  for (const Branch& branch : branches)
    if (branch.parent && branch.parent->label == point.label) list.push_back(&branch);
  return list;
}

/// Types of the special points in the order of the branch, without its ends: "PD LP".
inline std::string types_of(const Branch& branch) {
  std::string text;
  for (const SpecialPoint& point : branch.special_points) {
    if (point.type == PointType::EP) continue;
    text += (text.empty() ? "" : " ") + std::string(point_type_name(point.type));
  }
  return text;
}

inline std::string text_detail(const SpecialPoint& point, const char* name) {
  const auto found = point.details.find(name);
  return found == point.details.end() ? "" : std::get<std::string>(found->second);
}
inline double number_detail(const SpecialPoint& point, const char* name) { return std::get<double>(point.details.at(name)); }

}  // namespace graze::support
