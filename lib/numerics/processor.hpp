// SPDX-License-Identifier: GPL-3.0-or-later
// Instruction sets of this processor beyond the baseline for which the rest of the program is compiled.
#pragma once

namespace graze {

/// True if it has AVX2 and fused multiply-add.
bool processor_has_avx2_fma();
/// True if it has AVX-512 in addition.
bool processor_has_avx512();

}  // namespace graze
