// SPDX-License-Identifier: GPL-3.0-or-later
// Motions that stop when lanes would become idle, and motions that join them. Each is compared with the same motion alone.
#include "support/checks.hpp"
#include "support/lane_differences.hpp"
#include "support/lane_widths.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/lane_carrier.hpp>

#include <catch2/catch.hpp>

#include <algorithm>
#include <utility>

using namespace graze;
using namespace graze::support;

TEST_CASE("motions that stop together when lanes become idle continue to the same results") {
  const auto [model, law] = GENERATE(table<const char*, const char*>(
      {{"linear", "newton"}, {"linear", "hertz"}, {"cantilever", "newton"}, {"cantilever", "hertz"}}));
  const HybridSystem system = make_oscillator(model, law);
  const Vector p = parameters(system, {{"eta", 0.711}, {"r", 0.5}});
  const bool tangent = GENERATE(false, true);
  constexpr std::size_t count = 20;
  std::vector<MotionStart> starts = random_starts(count, 0.3, 1);
  starts.back() = {0, 0.8, 0.0};  // inside the barrier: inadmissible for the rigid stop
  const auto periods = [](std::size_t i) { return i < count / 2 ? 3 + i : 60 + 10 * i; };
  for (const LaneWidth width : widths_of_processor) {
    if (!available(width)) continue;
    INFO(model << ", " << law << ", " << static_cast<int>(width));
    LaneCarrier many(system, {}, width), whole(system);
    many.add_parameters(p);
    whole.add_parameters(p);
    std::vector<std::vector<PeriodResult>> results(count), expected(count);
    std::vector<MotionRun> runs;
    for (std::size_t i = 0; i < count; ++i) {
      results[i].resize(periods(i));
      runs.push_back({starts[i], periods(i), results[i].data()});
      whole.carry({starts[i]}, periods(i), tangent, expected[i]);
    }
    int turns = 0;
    RunSupply nobody_joins;
    nobody_joins.through = [](RunSupply&, MotionRun&, std::size_t) {};
    for (std::vector<MotionRun*> left; turns == 0 || !left.empty(); ++turns) {
      left.clear();
      for (MotionRun& run : runs)
        if (run.carried < run.periods) left.push_back(&run);
      if (turns == 1) CHECK(!left.empty());
      std::vector<std::size_t> before;
      for (const MotionRun* run : left) before.push_back(run->carried);
      many.carry_while_full(left, tangent, 1000, nobody_joins);
      for (std::size_t k = 0; k < left.size(); ++k) {
        REQUIRE(left[k]->carried > before[k]);
        REQUIRE(left[k]->carried <= left[k]->periods);
      }
    }
    CHECK(turns > 1);
    for (std::size_t i = 0; i < count; ++i) CHECK(same_bits(results[i], expected[i]));
  }
}

namespace {

/// Continues a motion that has used up its quota. When a motion is finished, a waiting one joins.
struct Joining : RunSupply {
  LaneCarrier& many;
  std::vector<MotionRun*> waiting;
  std::size_t share, joined = 0, shares = 0;
  Joining(LaneCarrier& lanes, std::vector<MotionRun*> others, std::size_t most)
      : many(lanes), waiting(std::move(others)), share(most) {
    through = [](RunSupply& self, MotionRun& run, std::size_t periods) { static_cast<Joining&>(self).update(run, periods); };
  }
  void update(MotionRun& run, std::size_t periods) {
    CHECK(periods <= share);
    if (run.carried < run.periods) {
      if (periods == share && many.join(run)) ++shares;
    } else if (!waiting.empty() && many.join(*waiting.back())) {
      waiting.pop_back();
      ++joined;
    }
  }
};

}  // namespace

TEST_CASE("motions that join others in the lanes have the same results") {
  const auto [model, law] = GENERATE(table<const char*, const char*>(
      {{"linear", "newton"}, {"linear", "hertz"}, {"linear", "linear"}, {"cantilever", "newton"}, {"cantilever", "hertz"}}));
  const HybridSystem system = make_oscillator(model, law);
  const Vector p = parameters(system, {{"eta", 0.711}, {"r", 0.5}});
  const bool tangent = GENERATE(false, true);
  constexpr std::size_t count = 60;
  std::vector<MotionStart> starts = random_starts(count, 0.3, 1);
  starts[30] = {0, 0.8, 0.0};  // inside the barrier: inadmissible for the rigid stop
  for (const LaneWidth width : widths_of_processor) {
    if (!available(width)) continue;
    for (const std::size_t at_first : {1, 3, 20}) {
      INFO(model << ", " << law << ", " << static_cast<int>(width) << ", " << at_first);
      LaneCarrier many(system, {}, width), whole(system);
      many.add_parameters(p);
      whole.add_parameters(p);
      std::vector<std::vector<PeriodResult>> results(count), expected(count);
      std::vector<MotionRun> runs;
      std::vector<MotionRun*> first, others;
      for (std::size_t i = 0; i < count; ++i) {
        results[i].resize(1 + i % 23);
        runs.push_back({starts[i], results[i].size(), results[i].data()});
        whole.carry({starts[i]}, results[i].size(), tangent, expected[i]);
      }
      for (std::size_t i = 0; i < count; ++i) (i < at_first ? first : others).push_back(&runs[i]);
      Joining supply(many, others, 5);
      while (!first.empty()) {
        many.carry_while_full(first, tangent, supply.share, supply);
        std::erase_if(first, [](const MotionRun* run) { return run->carried == run->periods; });
        for (MotionRun& run : runs)
          if (run.carried > 0 && run.carried < run.periods && std::find(first.begin(), first.end(), &run) == first.end())
            first.push_back(&run);
        if (first.empty() && !supply.waiting.empty()) {
          first.push_back(supply.waiting.back());
          supply.waiting.pop_back();
        }
      }
      CHECK(supply.joined > 20);
      CHECK(supply.shares > 20);
      for (std::size_t i = 0; i < count; ++i) {
        CHECK(runs[i].carried == runs[i].periods);
        CHECK(same_bits(results[i], expected[i]));
      }
    }
  }
}

TEST_CASE("a motion of another kind of flight or with a pending table of contacts does not join", "[sanitized]") {
  const HybridSystem system = make_oscillator("cantilever", "hertz");
  const Vector cubic = parameters(system, {{"eta", 0.711}, {"r", 0.5}});
  Vector linear = cubic;
  linear[static_cast<Eigen::Index>(parameter_index(system.parameters, "beta"))] = 0.0;
  LaneCarrier many(system);
  const std::size_t of_cubic = many.add_parameters(cubic), of_linear = many.add_parameters(linear);
  const std::size_t awaiting = many.add_parameters(linear);
  many.expect(awaiting, LaneCarrier::periods_for_table);
  REQUIRE(many.awaits_table(awaiting));
  PeriodResult first, second, third;
  MotionRun run{{of_linear, 0.0, 0.1}, 1, &first}, of_other{{of_cubic, 0.0, 0.1}, 1, &second},
      with_table{{awaiting, 0.0, 0.1}, 1, &third};
  struct Asking : RunSupply {
    LaneCarrier* many;
    MotionRun *other, *table;
    bool other_joined = true, table_joined = true;
  } supply;
  supply.many = &many;
  supply.other = &of_other;
  supply.table = &with_table;
  supply.through = [](RunSupply& self, MotionRun&, std::size_t) {
    auto& asking = static_cast<Asking&>(self);
    asking.other_joined = asking.many->join(*asking.other);
    asking.table_joined = asking.many->join(*asking.table);
  };
  MotionRun* const runs[] = {&run};
  many.carry_while_full(runs, false, 10, supply);
  CHECK(run.carried == 1);
  CHECK_FALSE(supply.other_joined);
  CHECK_FALSE(supply.table_joined);
  CHECK(of_other.carried == 0);
}
