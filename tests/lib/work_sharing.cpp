// SPDX-License-Identifier: GPL-3.0-or-later
// Pools on two threads that hand over computations, or motions of one computation. Each result is compared with the
// computation alone.
#include "support/checks.hpp"
#include "support/lane_differences.hpp"
#include "support/lane_plans.hpp"
#include "support/lane_widths.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/tasks/work_sharing.hpp>

#include <catch2/catch.hpp>

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

using namespace graze;
using namespace graze::support;

namespace {

/// A pool with computations, and another one that waits without any.
class TwoPools {
 public:
  explicit TwoPools(const HybridSystem& system) : first_(system), second_(system) {}

  void run(std::size_t count, const std::function<MotionTask<>(std::size_t, TaskSlot&)>& make) {
    std::thread other(
        [this] { TaskPool(second_, &exchange_).run([this](TaskSlot&, std::size_t carried) { return wait(carried); }); });
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return requests_ > 0; });
    }
    TaskPool(first_, &exchange_).run(count, make);
    end();
    other.join();
  }
  /// Number of periods carried by the other pool.
  std::size_t periods_by_second() const { return second_.carried(); }

 private:
  /// The other pool starts nothing of its own. It asks again after it has taken the work handed over.
  std::optional<MotionTask<>> wait(std::size_t carried) {
    std::unique_lock lock(mutex_);
    ++requests_;
    changed_.notify_all();
    if (carried > 0) return std::nullopt;
    exchange_.begin_waiting();
    changed_.wait(lock, [this] { return exchange_.has_some() || over_; });
    exchange_.end_waiting();
    return std::nullopt;
  }
  void end() {
    const std::lock_guard lock(mutex_);
    over_ = true;
    changed_.notify_all();
  }
  /// Work is available for the other pool. The first pool waits until the other has taken it. Otherwise it might finish alone
  /// if the other thread gets no processor in time.
  void wake() {
    std::unique_lock lock(mutex_);
    changed_.notify_all();
    changed_.wait(lock, [this] { return requests_ > 1; });
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t requests_ = 0;
  bool over_ = false;
  WorkSharing exchange_{[this] { wake(); }};
  LaneCarrier first_, second_;
};

}  // namespace

TEST_CASE("an idle pool gets half of the computations of another with the same results", "[threads]") {
  const std::string law = GENERATE("newton", "hertz");
  const HybridSystem system = make_oscillator("linear", law);
  constexpr std::size_t count = 60;
  const std::vector<MotionStart> starts = random_starts(count, 2.0);
  std::vector<Vector> sets;
  std::vector<Plan> plans;
  for (std::size_t i = 0; i < count; ++i) {
    sets.push_back(parameters(system, {{"eta", 0.6 + 0.001 * static_cast<double>(i)}}));
    plans.push_back({300 + 20 * i, 1 + i % 50, i % 3 == 0});
  }
  std::vector<std::vector<PeriodResult>> together(count);
  TwoPools pools(system);
  pools.run(count, [&](std::size_t i, TaskSlot& lane) { return follow(lane, sets[i], starts[i], plans[i], together[i]); });
  CHECK(pools.periods_by_second() > 1000);
  for (std::size_t i = 0; i < count; ++i) {
    INFO("computation " << i);
    CHECK(same_bits(together[i], follow_alone(system, sets[i], starts[i], plans[i])));
  }
}

namespace {

/// Many motions together, `times` times 32 periods; with a table of contacts or without.
MotionTask<> follow_all(TaskSlot& lane, const Vector& p, std::vector<MotionStart> motions, int times, bool table,
                        std::vector<PeriodResult>& out) {
  lane.set_parameters(p);
  if (table) lane.motions().expect(lane.parameters(), LaneCarrier::periods_for_table);
  constexpr std::size_t together = 32;
  for (int k = 0; k < times; ++k) {
    const std::span<const PeriodResult> next = co_await lane.carry(motions, together, k % 5 > 0);
    for (std::size_t m = 0; m < motions.size(); ++m) {
      const PeriodResult& end = next[(m + 1) * together - 1];
      if (end.termination == Termination::time) motions[m] = {0, end.x, end.v};
    }
    out.insert(out.end(), next.begin(), next.end());
  }
  CHECK((lane.motions().table(lane.parameters()) != nullptr) == table);
}

}  // namespace

TEST_CASE("motions of a single computation are shared with an idle pool with the same results") {
  const std::string law = GENERATE("newton", "hertz");
  const HybridSystem system = make_oscillator("linear", law);
  const Vector p = parameters(system, {{"eta", 0.711}, {"r", 1.0}});
  const bool table = law == "hertz" && GENERATE(true, false);
  std::vector<MotionStart> motions = random_starts(61, 0.9);
  if (law == "newton") motions[40] = {0, 2.0, 0.0};  // inside the barrier: ends at once
  std::vector<PeriodResult> alone, shared;
  LaneCarrier many(system);
  TaskPool(many).run(1, [&](std::size_t, TaskSlot& lane) { return follow_all(lane, p, motions, 60, table, alone); });
  TwoPools pools(system);
  pools.run(1, [&](std::size_t, TaskSlot& lane) { return follow_all(lane, p, motions, 60, table, shared); });
  CHECK(pools.periods_by_second() > 1000);
  CHECK(same_bits(alone, shared));
}
