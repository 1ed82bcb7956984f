// SPDX-License-Identifier: GPL-3.0-or-later
// TaskPool::Member: a task of a pool with its slot.
#pragma once

#include <graze/lib/tasks/task_pool.hpp>

namespace graze {

struct TaskPool::Member {
  TaskSlot place;
  MotionTask<> task;
};

}  // namespace graze
