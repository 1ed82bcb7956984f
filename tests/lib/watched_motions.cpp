// SPDX-License-Identifier: GPL-3.0-or-later
// Motions with an observer in lanes: the periods that are reported to the observer, against the complete motion.
#include "support/checks.hpp"
#include "support/lane_differences.hpp"
#include "support/lane_widths.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/lane_carrier.hpp>

#include <catch2/catch.hpp>

#include <limits>

using namespace graze;
using namespace graze::support;

namespace {

struct ReportedPeriod {
  std::size_t number;
  PeriodResult period;
};

/// Requests every `each`-th period, up to `last`.
struct RecordingObserver : PeriodObserver {
  std::size_t each = 1, last = 1;
  std::vector<ReportedPeriod> reports;
  RecordingObserver(std::size_t every, std::size_t end) : each(every), last(end) {
    next = each;
    see = [](PeriodObserver& self, std::size_t number, const PeriodResult& period) {
      auto& observer = static_cast<RecordingObserver&>(self);
      observer.reports.push_back({number, period});
      observer.next = number / observer.each * observer.each + observer.each;
      return number < observer.last;
    };
  }
};

/// A small ellipse around a state.
StateEllipse around(const PeriodResult& at, double size) { return {at.x, at.v, 1.0 / (size * size), 0.0, 1.0 / (size * size)}; }

bool in(const StateEllipse& e, const PeriodResult& at) {
  const double d = at.x - e.x0, d_v = at.v - e.v0;
  return e.xx * d * d + e.xv * d * d_v + e.vv * d_v * d_v <= 1.0;
}

bool same(const PeriodResult& a, const PeriodResult& b) { return same_bits({a}, {b}); }

}  // namespace

TEST_CASE("an observer gets the periods it requests and those that end in an ellipse until it stops") {
  const auto [model, law] = GENERATE(table<const char*, const char*>(
      {{"linear", "newton"}, {"linear", "hertz"}, {"linear", "linear"}, {"cantilever", "newton"}, {"cantilever", "hertz"}}));
  const HybridSystem system = make_oscillator(model, law);
  const Vector p = parameters(system, {{"eta", 0.711}, {"r", 0.5}});
  constexpr std::size_t count = 21, most = 60;
  std::vector<MotionStart> starts = random_starts(count, 0.3, 1);
  for (const LaneWidth width : widths_of_processor) {
    if (!available(width)) continue;
    INFO(model << ", " << law << ", " << static_cast<int>(width));
    LaneCarrier whole(system, {}, width), many(system, {}, width);
    whole.add_parameters(p);
    many.add_parameters(p);
    std::vector<PeriodResult> expected;
    whole.carry(starts, most, false, expected);
    const StateEllipse first = around(expected[0], 0.01), other = around(expected[5 * most + 30], 0.02);
    many.set_reported_ellipses({first, other});
    std::vector<RecordingObserver> watches;
    std::vector<PeriodResult> last(count);
    std::vector<MotionRun> runs;
    watches.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      watches.emplace_back(1 + i % 7, 7 + 2 * i);
      runs.push_back(
          {.start = starts[i], .periods = std::numeric_limits<std::size_t>::max(), .results = &last[i], .watch = &watches[i]});
    }
    many.carry(runs, false);
    std::size_t by_ellipse = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const RecordingObserver& watch = watches[i];
      std::size_t next = 0;
      bool ended = false;
      for (std::size_t k = 1; k <= most && !ended; ++k) {
        const PeriodResult& period = expected[i * most + k - 1];
        const bool inside = in(first, period) || in(other, period);
        if (k % watch.each != 0 && !inside) continue;
        by_ellipse += k % watch.each != 0 ? 1 : 0;
        REQUIRE(next < watch.reports.size());
        REQUIRE(watch.reports[next].number == k);
        CHECK(same(watch.reports[next++].period, period));
        ended = k >= watch.last;
      }
      CHECK(ended);
      CHECK(next == watch.reports.size());
      CHECK(runs[i].carried == watch.reports.back().number);
      CHECK(runs[i].periods == runs[i].carried);
      CHECK(same(last[i], watch.reports.back().period));
    }
    CHECK(by_ellipse > 1);
  }
}

TEST_CASE("an observer receives a failed period and the periods left to the Propagator", "[sanitized]") {
  const HybridSystem system = make_oscillator("linear", "newton");
  const Vector p = parameters(system, {{"eta", 0.2}, {"r", 0.3}, {"k_r", 0.5}});  // the mass sticks
  const std::vector<MotionStart> starts = {{0, 0.0, 0.0}, {0, 0.4, 0.0}, {0, 0.3, -0.5}};
  constexpr std::size_t periods = 5;
  LaneCarrier whole(system), many(system);
  whole.add_parameters(p);
  many.add_parameters(p);
  std::vector<PeriodResult> expected, last(starts.size());
  whole.carry(starts, periods, false, expected);
  std::vector<RecordingObserver> watches;
  std::vector<MotionRun> runs;
  watches.reserve(starts.size());
  for (std::size_t i = 0; i < starts.size(); ++i) {
    watches.emplace_back(periods, periods);
    runs.push_back({.start = starts[i], .periods = 1000, .results = &last[i], .watch = &watches[i]});
  }
  many.carry(runs, false);
  CHECK(many.left_over() > 0);
  for (const std::size_t i : {0, 2}) {
    REQUIRE(!watches[i].reports.empty());
    CHECK(watches[i].reports.back().number == periods);
    CHECK(same(watches[i].reports.back().period, expected[i * periods + periods - 1]));
  }
  REQUIRE(watches[1].reports.size() == 1);  // it began inside the barrier
  CHECK(watches[1].reports[0].number == 1);
  CHECK(watches[1].reports[0].period.termination == Termination::inadmissible_start);
}
