// SPDX-License-Identifier: GPL-3.0-or-later
// WideRegisters: clears the upper halves of the registers that the lanes use. While they are not clear, code compiled for SSE
// alone (the rest of the program) takes up to six times as long on Intel's processors. The compiler clears them at the end of
// functions that use them, but not on every path out of the lanes.
#pragma once

#include <graze/lib/lanes/real.hpp>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Clears them in its destructor.
struct WideRegisters {
  [[gnu::always_inline]] static void leave() {
#ifdef GRAZE_FUSED
    _mm256_zeroupper();
#endif
  }
  [[gnu::always_inline]] ~WideRegisters() { leave(); }
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
