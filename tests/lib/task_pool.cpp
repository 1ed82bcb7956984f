// SPDX-License-Identifier: GPL-3.0-or-later
// Computations that share the lanes, each at its own pace. Each is compared with the same computation alone.
#include "support/checks.hpp"
#include "support/lane_differences.hpp"
#include "support/lane_plans.hpp"
#include "support/lane_widths.hpp"

#include <graze/lib/models/oscillator.hpp>

#include <catch2/catch.hpp>

#include <stdexcept>

using namespace graze;
using namespace graze::support;

namespace {

bool same_motion(const PeriodResult& a, const PeriodResult& b) {
  return a.termination == b.termination && a.x == b.x && a.v == b.v && a.impacts == b.impacts;
}

MotionTask<int> twice(TaskSlot& lane, int number) {
  const Vector state{{0.0, 0.1 * number}};
  const CarriedPeriods one = co_await lane.carry(state, 1);
  if (number == 5) throw std::runtime_error("five");
  co_return 2 * number + (one.size() == 1 ? 0 : 1);
}

struct Counted {
  explicit Counted(int& alive) : alive_(alive) { ++alive_; }
  Counted(const Counted&) = delete;
  ~Counted() { --alive_; }
  int& alive_;
};

MotionTask<> ask_twice(TaskSlot& lane, const Vector& p, int number, int& alive, int& sum) {
  const Counted counted(alive);
  lane.set_parameters(p);
  const int once = co_await twice(lane, number);
  const int again = co_await twice(lane, number);
  sum += once + again;
}

}  // namespace

TEST_CASE("computations in a pool give the results of each alone", "[sanitized]") {
  const std::string law = GENERATE("newton", "hertz");
  const HybridSystem system = make_oscillator("linear", law);
  const std::size_t count = GENERATE(1, 20, 300);  // more than run at a time
  const std::vector<MotionStart> starts = random_starts(count, 2.0);
  std::vector<Vector> sets;
  std::vector<Plan> plans;
  for (std::size_t i = 0; i < count; ++i) {
    sets.push_back(parameters(system, {{"eta", 0.6 + 0.001 * static_cast<double>(i)}}));
    plans.push_back({i % 7 == 0 ? 150 : 1 + i % 40, 1 + i % 50, i % 3 == 0});
  }
  std::vector<std::vector<PeriodResult>> together(count);
  LaneCarrier many(system);
  TaskPool pool(many);
  pool.run(count, [&](std::size_t i, TaskSlot& lane) { return follow(lane, sets[i], starts[i], plans[i], together[i]); });
  for (std::size_t i = 0; i < count; ++i) {
    INFO("computation " << i << " of " << count);
    CHECK(same_bits(together[i], follow_alone(system, sets[i], starts[i], plans[i])));
  }
}

namespace {

/// Uses its own parameter sets one after the other. Memory that is freed and reused in between puts the sets of others at the
/// same addresses.
MotionTask<> go_through(TaskSlot& lane, std::vector<Vector> sets, std::vector<PeriodResult>& out) {
  MotionStart start{0, 0.1, 0.0};
  for (const Vector& p : sets) {
    lane.set_parameters(sets.front());
    lane.set_parameters(p);
    start.parameters = lane.parameters();
    const std::span<const PeriodResult> next = co_await lane.carry({&start, 1}, 3, true);
    out.insert(out.end(), next.begin(), next.end());
  }
}

}  // namespace

TEST_CASE("parameters that change while others are carried are read again", "[sanitized]") {
  const HybridSystem system = make_oscillator("linear", "newton");
  constexpr std::size_t changes = 50;
  // With 3, a lane gets its previous computation; with 40, another one.
  const std::size_t count = GENERATE(std::size_t{3}, std::size_t{40});
  std::vector<std::vector<Vector>> sets(count);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < changes; ++k)
      sets[i].push_back(parameters(system, {{"eta", 0.6 + 0.0001 * static_cast<double>(i * changes + k)}}));
  std::vector<std::vector<PeriodResult>> together(count);
  LaneCarrier many(system);
  TaskPool pool(many);
  pool.run(count, [&](std::size_t i, TaskSlot& lane) { return go_through(lane, sets[i], together[i]); });
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < changes; ++k) {
      std::vector<PeriodResult> alone;
      LaneCarrier one(system);
      one.carry({{one.add_parameters(sets[i][k]), 0.1, 0.0}}, 3, true, alone);
      REQUIRE(together[i].size() == 3 * changes);
      wrong += same_bits({together[i].begin() + static_cast<std::ptrdiff_t>(3 * k),
                          together[i].begin() + static_cast<std::ptrdiff_t>(3 * k + 3)},
                         alone)
                   ? 0
                   : 1;
    }
  CHECK(wrong == 0);
}

TEST_CASE("a computation in a pool requests several motions and some of them end", "[sanitized]") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.711}, {"r", 0.3}});
  LaneCarrier many(system);
  const std::size_t set = many.add_parameters(p);
  const std::vector<MotionStart> starts = {{set, 0.0, 0.0}, {set, 0.4, 0.0}, {set, -0.5, 0.1}};  // one inside the barrier
  constexpr std::size_t periods = 50;
  std::vector<PeriodResult> alone, pooled;
  many.carry(starts, periods, false, alone);
  const auto request = [](TaskSlot& lane, const std::vector<MotionStart>& requested,
                          std::vector<PeriodResult>& out) -> MotionTask<> {
    const std::span<const PeriodResult> nothing = co_await lane.carry({}, 3, true);
    CHECK(nothing.empty());
    const std::span<const PeriodResult> results = co_await lane.carry(requested, periods, false);
    out.assign(results.begin(), results.end());
  };
  TaskPool pool(many);
  pool.run(1, [&](std::size_t, TaskSlot& lane) { return request(lane, starts, pooled); });
  REQUIRE(pooled.size() == alone.size());
  for (std::size_t k = 0; k < alone.size(); ++k) {
    CHECK(pooled[k].termination == alone[k].termination);
    CHECK(pooled[k].termination == (k / periods == 1 ? Termination::inadmissible_start : Termination::time));
    if (k / periods != 1) CHECK(same_motion(pooled[k], alone[k]));
  }
}

TEST_CASE("computations wait for each other and an exception in one ends the pool", "[threads]") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {});
  LaneCarrier many(system);
  TaskPool pool(many);
  int alive = 0, sum = 0;
  pool.run(5, [&](std::size_t i, TaskSlot& lane) { return ask_twice(lane, p, static_cast<int>(i), alive, sum); });
  CHECK(sum == 4 * (0 + 1 + 2 + 3 + 4));
  CHECK(alive == 0);
  CHECK_THROWS_WITH(
      pool.run(400, [&](std::size_t i, TaskSlot& lane) { return ask_twice(lane, p, static_cast<int>(i), alive, sum); }), "five");
  CHECK(alive == 0);
  pool.run(0, [&](std::size_t i, TaskSlot& lane) { return ask_twice(lane, p, static_cast<int>(i), alive, sum); });
}

TEST_CASE("a task carries its motions in lanes or by a Propagator with the same results", "[sanitized]") {
  const char* law = GENERATE("newton", "hertz");
  const HybridSystem system = make_oscillator("linear", law);
  const Vector p = parameters(system, {{"eta", 0.93}}), overdamped = parameters(system, {{"b", 1.1}, {"eta", 0.93}});
  const Vector start{{0.3, 0.4}};
  constexpr std::size_t periods = 12;
  struct Motion {
    std::vector<Vector> states = {};
    std::vector<double> speeds = {};
  };
  const auto carry = [&](TaskSlot& slot, const Vector& at, bool in_lanes, Motion& out) -> MotionTask<> {
    slot.set_parameters(at);
    CHECK(slot.in_lanes() == in_lanes);
    ImpactSpeeds speeds;
    const CarriedPeriods carried = co_await slot.carry(start, periods, &speeds);
    CHECK(carried.size() == periods);
    Vector state(2);
    for (std::size_t k = 0; k < carried.size(); ++k) {
      CHECK(carried.termination(k) == Termination::time);
      carried.state(k, state);
      out.states.push_back(state);
    }
    out.speeds = speeds.list();
  };
  Motion lanes, alone, other, other_alone;
  LaneCarrier many(system);
  TaskPool(many).run(2, [&](std::size_t i, TaskSlot& slot) {
    return i == 0 ? carry(slot, p, true, lanes) : carry(slot, overdamped, false, other);
  });
  run_alone(system, {}, [&](TaskSlot& slot) { return carry(slot, p, false, alone); });
  run_alone(system, {}, [&](TaskSlot& slot) { return carry(slot, overdamped, false, other_alone); });
  REQUIRE(lanes.states.size() == periods);
  REQUIRE(alone.states.size() == periods);
  for (std::size_t k = 0; k < periods; ++k) CHECK((lanes.states[k] - alone.states[k]).norm() < 1e-9);
  REQUIRE(lanes.speeds.size() > 5);
  REQUIRE(lanes.speeds.size() == alone.speeds.size());
  for (std::size_t i = 0; i < lanes.speeds.size(); ++i) CHECK(lanes.speeds[i] == Approx(alone.speeds[i]).epsilon(1e-8));
  CHECK(other.states == other_alone.states);
  CHECK((other.states.back() - alone.states.back()).norm() > 1e-3);
}

TEST_CASE("the periods of a motion that ends have the termination of its end", "[sanitized]") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector inside_barrier{{5.0, 0.0}}, rest{{0.0, 0.0}};
  run_alone(system, {}, [&](TaskSlot& slot) -> MotionTask<> {
    slot.set_parameters(parameters(system, {}));
    const CarriedPeriods carried = co_await slot.carry(inside_barrier, 3);
    CHECK(carried.size() == 3);
    for (std::size_t k = 0; k < 3; ++k) CHECK(carried.termination(k) != Termination::time);
    const CarriedPeriods none = co_await slot.carry(rest, 0);
    CHECK(none.size() == 0);
  });
}

TEST_CASE("with a table of contacts the result of a computation does not depend on the others") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"eta", 0.711}});
  const auto average = [&](TaskSlot& lane, std::vector<PeriodResult>& out, bool& has_table) -> MotionTask<> {
    lane.set_parameters(p);
    lane.motions().expect(lane.parameters(), LaneCarrier::periods_for_table);
    MotionStart start = lane.at(Vector{{0.1, 0.0}});
    for (int turn = 0; turn < 150; ++turn) {
      const std::span<const PeriodResult> next = co_await lane.carry({&start, 1}, 32, true);
      out.insert(out.end(), next.begin(), next.end());
      start.x = out.back().x;
      start.v = out.back().v;
    }
    has_table = lane.motions().table(lane.parameters()) != nullptr;
  };
  std::vector<PeriodResult> alone;
  for (const std::size_t company : {0, 1, 25}) {
    std::vector<PeriodResult> own;
    std::vector<std::vector<PeriodResult>> of_others(company);
    bool has_table = false;
    LaneCarrier many(system);
    TaskPool pool(many);
    const std::vector<MotionStart> starts = random_starts(company, 1.0);
    pool.run(company + 1, [&](std::size_t i, TaskSlot& lane) {
      return i == company ? average(lane, own, has_table) : follow(lane, p, starts[i], {5000, 1 + i, true}, of_others[i]);
    });
    CHECK(has_table);
    if (company == 0) alone = own;
    INFO("in the company of " << company);
    CHECK(same_bits(own, alone));
  }
}

TEST_CASE("an urgent computation is served every round among many of the other kind", "[threads]") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {});
  std::size_t tangents = 0, before = 0;
  const auto many_turns = [](TaskSlot& lane, const Vector& at, std::size_t& periods) -> MotionTask<> {
    lane.set_parameters(at);
    MotionStart start = lane.at(Vector{{0.0, 0.0}});
    for (int turn = 0; turn < 40; ++turn, ++periods) {
      const std::span<const PeriodResult> next = co_await lane.carry({&start, 1}, 1, true);
      start.x = next[0].x;
      start.v = next[0].v;
    }
  };
  const auto once = [](TaskSlot& lane, const Vector& at, bool hurries, const std::size_t& done,
                       std::size_t& seen) -> MotionTask<> {
    lane.set_parameters(at);
    lane.hurry(hurries);
    const Vector rest = Vector::Zero(2);
    co_await lane.carry(rest, 1);
    seen = done;
  };
  const bool hurries = GENERATE(true, false);
  LaneCarrier many(system);
  TaskPool pool(many);
  pool.run(20, [&](std::size_t i, TaskSlot& lane) {
    return i == 0 ? once(lane, p, hurries, tangents, before) : many_turns(lane, p, tangents);
  });
  CHECK(tangents == 19 * 40);
  CHECK((before == 0) == hurries);  // otherwise it waits until few of the others are left
}

TEST_CASE("of many computations the longest one gets ahead of the others and keeps its recorded impacts") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.711}});
  constexpr std::size_t count = 40, together = 32, last = 640 * together;
  std::size_t of_first = 0, of_others = 0, speeds = 0, impacts = 0;
  const auto carry_on = [&](TaskSlot& lane, bool first) -> MotionTask<> {
    lane.set_parameters(p);
    Vector at{{0.1, 0.0}};
    for (std::size_t own = 0; own < last && of_first < last;) {
      ImpactSpeeds list;
      const bool written = first && own % (2 * together) == 0;
      const std::size_t periods = first && own == 0 ? 4 * together : together;  // so that this one has lasted longest
      const CarriedPeriods next = co_await lane.carry(at, periods, written ? &list : nullptr);
      next.state(periods - 1, at);
      own += periods;
      (first ? of_first : of_others) += periods;
      speeds += list.list().size();
      for (std::size_t k = 0; k < next.size(); ++k) impacts += written ? static_cast<std::size_t>(next.impacts(k)) : 0;
    }
  };
  LaneCarrier many(system);
  TaskPool(many).run(count, [&](std::size_t i, TaskSlot& lane) { return carry_on(lane, i == 0); });
  CHECK(of_first == last);
  CHECK(impacts > 1000);
  CHECK(speeds == impacts);
  // (Without priority all would have the same number of periods.)
  CHECK(static_cast<double>(of_others) / (count - 1) < 0.75 * last);
}

TEST_CASE("parameters move to other motions with their table of contacts") {
  const HybridSystem system = make_oscillator("linear", "hertz");
  const Vector p = parameters(system, {{"eta", 0.711}});
  LaneCarrier from(system), to(system);
  from.add_parameters(parameters(system, {{"eta", 0.8}}));
  const std::size_t set = from.add_parameters(p);
  from.expect(set, LaneCarrier::periods_for_table);
  std::vector<PeriodResult> results, there;
  from.carry({{set, 0.0, 0.0}}, 4000, false, results);
  const std::shared_ptr<const ContactTable> table = from.table(set);
  REQUIRE(table);
  const MotionStart start{set, results.back().x, results.back().v};
  from.carry({start}, 20, true, results);
  const std::size_t arrived = to.add(from.take(set));
  CHECK(arrived == 0);
  CHECK(to.table(arrived) == table);
  to.carry({{arrived, start.x, start.v}}, 20, true, there);
  CHECK(same_bits(results, there));
  CHECK_THROWS_WITH(from.carry({start}, 1, false, results), "parameter set 1 was taken");
  from.change_parameters(set, p);
  CHECK(from.table(set) == nullptr);
  CHECK(from.add(to.take(arrived), set) == set);
  CHECK(from.table(set) == table);
  CHECK_THROWS_WITH(to.change_parameters(3, p), Catch::Contains("parameter set 3; 1 were added"));
}
