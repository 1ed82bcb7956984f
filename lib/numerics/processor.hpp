// SPDX-License-Identifier: GPL-3.0-or-later
// What this processor has beyond the instructions that the rest of the program is compiled for.
#pragma once

namespace graze {

/// AVX2 and fused multiply-add.
bool processor_fuses();
/// AVX-512 besides.
bool processor_has_avx512();

}  // namespace graze
