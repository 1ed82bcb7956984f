// SPDX-License-Identifier: GPL-3.0-or-later
// Lane widths with identical bits.
#pragma once

#include <graze/lib/motion/lane_carrier.hpp>

#include <vector>

namespace graze::support {

/// Those with the processor's fused multiply-add, and those without.
inline const std::vector<LaneWidth> widths_of_processor = {LaneWidth::one, LaneWidth::two, LaneWidth::four, LaneWidth::eight,
                                                           LaneWidth::widest};
inline const std::vector<LaneWidth> plain_widths = {LaneWidth::plain_one, LaneWidth::plain_two};

inline bool same_bits(const std::vector<PeriodResult>& a, const std::vector<PeriodResult>& b) {
  bool same = a.size() == b.size();
  for (std::size_t i = 0; same && i < a.size(); ++i)
    same = a[i].x == b[i].x && a[i].v == b[i].v && a[i].Phi == b[i].Phi && a[i].det == b[i].det && a[i].impacts == b[i].impacts &&
           a[i].liouville == b[i].liouville && a[i].termination == b[i].termination;
  return same;
}

}  // namespace graze::support
