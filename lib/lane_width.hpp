// SPDX-License-Identifier: GPL-3.0-or-later
// LaneWidth: how many motions are carried side by side in SIMD registers, and what carries them.
#pragma once

#include <graze/lib/lanes/job.hpp>

namespace graze {

/// How many lanes: `widest` is what the processor has.
enum class LaneWidth { widest, one, generic, avx2, avx512 };

/// Whether this processor has lanes of that kind.
bool available(LaneWidth width);

/// What the lanes of a width do.
struct LaneKernels {
  void (*carry)(const lanes::Job&);
  void (*contacts)(const lanes::ContactJob&);
};

/// @throws std::invalid_argument where this processor does not have them.
LaneKernels lane_kernels(LaneWidth width);

}  // namespace graze
