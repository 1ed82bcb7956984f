// SPDX-License-Identifier: GPL-3.0-or-later
// LaneWidth: number of motions side by side in SIMD registers, and the kernels that carry them.
#pragma once

#include <graze/lib/lanes/job.hpp>

namespace graze {

/// Number of lanes, with fused multiply-add if the processor has it. `widest` is the most that the processor has, `four` needs
/// AVX2, `eight` AVX-512. The plain widths do without fused multiply-add on every processor.
enum class LaneWidth { widest, one, two, four, eight, plain_one, plain_two };

/// Whether this processor has this width.
bool available(LaneWidth width);

/// The smallest width that holds `motions` motions at once, or the widest. On one processor, all but the plain widths give the
/// same result to the last bit; idle lanes cost as much as busy ones.
LaneWidth width_for(std::size_t motions);

/// The kernels of a width.
struct LaneKernels {
  void (*carry)(const lanes::Job&);
  void (*contacts)(const lanes::ContactJob&);
};

/// @throws std::invalid_argument if this processor does not have the width.
LaneKernels lane_kernels(LaneWidth width);

}  // namespace graze
