// SPDX-License-Identifier: GPL-3.0-or-later
// WideRegisters: the upper halves of the registers that the lanes use. While they are not empty, code compiled for SSE alone (all
// the rest of the program) takes up to six times as long on Intel's processors. The compiler sees to it at the end of functions
// that use them, but not on every way out of the lanes.
#pragma once

#include <graze/lib/lanes/real.hpp>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Empties them at its end.
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
