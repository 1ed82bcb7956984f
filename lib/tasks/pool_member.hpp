// SPDX-License-Identifier: GPL-3.0-or-later
// A computation in a TaskPool, with its place there.
#pragma once

#include <graze/lib/tasks/task_pool.hpp>

namespace graze {

struct TaskPool::Member {
  TaskSlot place;
  MotionTask<> task;
};

}  // namespace graze
