// SPDX-License-Identifier: GPL-3.0-or-later
// find_attractor from each start, as tasks of one pool.
#pragma once

#include <graze/floquet/attractor/attractor_task.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <vector>

namespace graze::support {

inline MotionTask<> find_into(TaskSlot& slot, const AverageStart& start, const AttractorOptions& options, Attractor& attractor) {
  attractor = co_await approach_attractor(slot, start.p, start.state, options);
  co_await average_on_attractor(slot, start.p, attractor, options);
}

inline std::vector<Attractor> find_each_attractor(const HybridSystem& system, const std::vector<AverageStart>& starts,
                                                  const AttractorOptions& options) {
  std::vector<Attractor> out(starts.size());
  run_tasks(system, options.lyapunov.flow, false, starts.size(),
            [&](std::size_t i, TaskSlot& slot) { return find_into(slot, starts[i], options, out[i]); });
  return out;
}

}  // namespace graze::support
