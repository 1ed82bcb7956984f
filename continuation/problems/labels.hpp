// SPDX-License-Identifier: GPL-3.0-or-later
// Labels: creates the labels "PD1", "PD2", "LP1", ... of special points, numbered by type over a whole run.
#pragma once

#include <graze/continuation/problems/special_point.hpp>

#include <algorithm>
#include <charconv>
#include <map>
#include <string>

namespace graze {

class Labels {
 public:
  /// The next unused label of this type.
  std::string next(PointType type) { return std::string(point_type_name(type)) + std::to_string(++count_[type]); }
  /// Marks the label of an existing point as used: later numbers of its type are larger.
  void take(const SpecialPoint& point) {
    const std::string number = point.label.substr(std::min(point.label.size(), point_type_name(point.type).size()));
    int value = 0;
    std::from_chars(number.data(), number.data() + number.size(), value);
    count_[point.type] = std::max(count_[point.type], value);
  }

 private:
  std::map<PointType, int> count_;
};

}  // namespace graze
