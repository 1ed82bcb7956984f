// SPDX-License-Identifier: GPL-3.0-or-later
// LaneWidth: how many motions are carried side by side in SIMD registers, and what carries them.
#pragma once

#include <graze/lib/lanes/job.hpp>

namespace graze {

/// How many lanes, with fused multiply-add where the processor has it: `widest` is what the processor has, `four` want AVX2,
/// `eight` AVX-512. The plain ones are without on any processor.
enum class LaneWidth { widest, one, two, four, eight, plain_one, plain_two };

/// Whether this processor has lanes of that kind.
bool available(LaneWidth width);

/// The least width that takes so many motions at once, or the widest. All but the plain ones give the same result to the last
/// bit on a processor; idle lanes cost as much as busy ones.
LaneWidth width_for(std::size_t motions);

/// What the lanes of a width do.
struct LaneKernels {
  void (*carry)(const lanes::Job&);
  void (*contacts)(const lanes::ContactJob&);
};

/// @throws std::invalid_argument where this processor does not have them.
LaneKernels lane_kernels(LaneWidth width);

}  // namespace graze
