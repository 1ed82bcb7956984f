// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lanes/lane_width.hpp>
#include <graze/lib/numerics/processor.hpp>

#include <stdexcept>

namespace graze {

namespace {

using namespace lanes;

LaneWidth widest_available() {
  for (const LaneWidth width : {LaneWidth::eight, LaneWidth::four})
    if (available(width)) return width;
  return LaneWidth::two;
}

}  // namespace

bool available(LaneWidth width) {
  if (width == LaneWidth::four) return processor_has_avx2_fma();
  if (width == LaneWidth::eight) return processor_has_avx512();
  return true;
}

LaneWidth width_for(std::size_t motions) {
  if (motions <= 1) return LaneWidth::one;
  if (motions <= 2) return LaneWidth::two;
  return motions <= 4 && available(LaneWidth::four) ? LaneWidth::four : widest_available();
}

LaneKernels lane_kernels(LaneWidth width) {
  if (!available(width)) throw std::invalid_argument("this processor does not have the lanes asked for");
  if (width == LaneWidth::widest) width = widest_available();
#ifdef GRAZE_X86_LANES
  if (width == LaneWidth::eight) return {fused::carry_eight, fused::contacts_eight};
  if (width == LaneWidth::four) return {fused::carry_four, fused::contacts_four};
  if (width == LaneWidth::two && processor_has_avx2_fma()) return {fused::carry_two, fused::contacts_two};
  if (width == LaneWidth::one && processor_has_avx2_fma()) return {fused::carry_one, fused::contacts_one};
#endif
  if (width == LaneWidth::two || width == LaneWidth::plain_two) return {plain::carry_two, plain::contacts_two};
  return {plain::carry_one, plain::contacts_one};
}

}  // namespace graze
