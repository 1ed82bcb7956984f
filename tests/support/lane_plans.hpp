// SPDX-License-Identifier: GPL-3.0-or-later
// The requests of computations in a pool, and the results of each alone.
#pragma once

#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace graze::support {

/// A request: a number of periods, `step` at a time, with the tangent every other time or not at all.
struct Plan {
  std::size_t periods, step;
  bool tangent;
  std::size_t next(std::size_t done) const { return std::min(step, periods - done); }
  bool with_tangent(std::size_t done) const { return tangent && (done / step) % 2 == 0; }
};

inline MotionTask<> follow(TaskSlot& lane, const Vector& p, MotionStart start, Plan plan, std::vector<PeriodResult>& out) {
  lane.set_parameters(p);
  start.parameters = lane.parameters();
  while (out.size() < plan.periods) {
    const std::span<const PeriodResult> next =
        co_await lane.carry({&start, 1}, plan.next(out.size()), plan.with_tangent(out.size()));
    out.insert(out.end(), next.begin(), next.end());
    start.x = out.back().x;
    start.v = out.back().v;
  }
}

inline std::vector<PeriodResult> follow_alone(const HybridSystem& system, const Vector& p, MotionStart start, const Plan& plan) {
  LaneCarrier many(system);
  start.parameters = many.add_parameters(p);
  std::vector<PeriodResult> out, next;
  while (out.size() < plan.periods) {
    many.carry({start}, plan.next(out.size()), plan.with_tangent(out.size()), next);
    out.insert(out.end(), next.begin(), next.end());
    start.x = out.back().x;
    start.v = out.back().v;
  }
  return out;
}

}  // namespace graze::support
