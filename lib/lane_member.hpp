// SPDX-License-Identifier: GPL-3.0-or-later
// A computation in a LanePool, with its place there.
#pragma once

#include <graze/lib/lane_pool.hpp>

namespace graze {

struct LanePool::Member {
  LanePlace place;
  LaneTask<> task;
};

}  // namespace graze
