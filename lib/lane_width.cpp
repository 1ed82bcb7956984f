// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/lane_width.hpp>

#include <xsimd/config/xsimd_cpuid.hpp>

#include <stdexcept>

namespace graze {

bool available(LaneWidth width) {
#ifdef GRAZE_X86_LANES
  const auto has = xsimd::available_architectures();
  if (width == LaneWidth::avx2) return has.avx2;
  if (width == LaneWidth::avx512) return has.avx512f;
#endif
  return width != LaneWidth::avx2 && width != LaneWidth::avx512;
}

LaneWidth width_for(std::size_t motions) {
  if (motions <= 1) return LaneWidth::one;
  if (motions <= 2) return LaneWidth::generic;
  return motions <= 4 && available(LaneWidth::avx2) ? LaneWidth::avx2 : LaneWidth::widest;
}

LaneKernels lane_kernels(LaneWidth width) {
  if (!available(width)) throw std::invalid_argument("this processor does not have the lanes asked for");
  switch (width) {
  case LaneWidth::one:
    return {lanes::carry_one, lanes::contacts_one};
  case LaneWidth::generic:
    return {lanes::carry_generic, lanes::contacts_generic};
#ifdef GRAZE_X86_LANES
  case LaneWidth::avx2:
    return {lanes::carry_avx2, lanes::contacts_avx2};
  case LaneWidth::avx512:
    return {lanes::carry_avx512, lanes::contacts_avx512};
#endif
  default:
    break;
  }
  for (const LaneWidth wide : {LaneWidth::avx512, LaneWidth::avx2})
    if (available(wide)) return lane_kernels(wide);
  return lane_kernels(LaneWidth::generic);
}

}  // namespace graze
