// SPDX-License-Identifier: GPL-3.0-or-later
// Range: the values that one axis of a picture must show.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace graze::apps {

struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
  void take(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  bool empty() const { return !(low <= high); }
  /// The range widened by a share of its width on either side; its width is never zero.
  std::array<double, 2> with_margin(double share) const {
    const double margin = share * std::max(high - low, 1e-9 * (1.0 + std::abs(high)));
    return {low - margin, high + margin};
  }
};

}  // namespace graze::apps
