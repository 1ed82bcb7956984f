// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/numerics/processor.hpp>

#include <xsimd/config/xsimd_cpuid.hpp>

namespace graze {

bool processor_has_avx2_fma() {
#ifdef GRAZE_X86_LANES
  return xsimd::available_architectures().fma3_avx2;
#else
  return false;
#endif
}

bool processor_has_avx512() { return processor_has_avx2_fma() && xsimd::available_architectures().avx512f; }

}  // namespace graze
