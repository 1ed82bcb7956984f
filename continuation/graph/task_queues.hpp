// SPDX-License-Identifier: GPL-3.0-or-later
// TaskQueues: the branches that a BranchGraph has yet to follow, in order of priority.
#pragma once

#include <graze/continuation/branch/branch_task.hpp>

#include <deque>
#include <utility>
#include <vector>

namespace graze {

class TaskQueues {
 public:
  void add(BranchTask task) { queue_of(task).push_back(std::move(task)); }
  bool empty() const { return others_.empty() && seeds_.empty() && multiples_.empty(); }

  /// Removes and returns the tasks of the next round, which run in parallel: about `most`.
  std::vector<BranchTask> next_round(std::size_t most) {
    std::vector<BranchTask> round;
    const auto take = [&](std::deque<BranchTask>& queue) {
      for (; !queue.empty() && round.size() < most; queue.pop_front()) round.push_back(std::move(queue.front()));
    };
    take(others_);
    // The next seed waits until everything connected with the last one is done: most other seeds lie on it.
    if (round.empty() && !seeds_.empty()) {
      const int seed = seeds_.front().seed;
      for (; !seeds_.empty() && seeds_.front().seed == seed; seeds_.pop_front()) round.push_back(std::move(seeds_.front()));
    }
    // Families of a multiple of a period, mostly unstable, come last: they must not displace others under the limit of
    // branches.
    if (round.empty()) take(multiples_);
    return round;
  }

  /// Calls visit(task) for each remaining task.
  template <class Visit> void for_each(const Visit& visit) const {
    for (const auto* queue : {&others_, &seeds_, &multiples_})
      for (const BranchTask& task : *queue) visit(task);
  }

 private:
  std::deque<BranchTask>& queue_of(const BranchTask& task) {
    return task.origin == BranchOrigin::seed ? seeds_ : task.is(GrazingFamily::Kind::multiple) ? multiples_ : others_;
  }

  std::deque<BranchTask> others_, seeds_, multiples_;
};

}  // namespace graze
