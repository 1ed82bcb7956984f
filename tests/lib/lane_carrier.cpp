// SPDX-License-Identifier: GPL-3.0-or-later
// Motions side by side in SIMD lanes, against the same motions one by one (Propagator), and against fewer lanes.
#include "support/checks.hpp"
#include "support/lane_differences.hpp"
#include "support/lane_widths.hpp"
#include "support/two_sided_oscillator.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/lane_carrier.hpp>

#include <catch2/catch.hpp>
#include <oneapi/tbb/task_arena.h>

#include <cstring>

using namespace graze;
using namespace graze::support;

namespace {

HybridSystem oscillator(const char* law) { return make_oscillator("linear", law); }

}  // namespace

TEST_CASE("lanes and Propagator agree", "[sanitized]") {
  const auto [law, parameter, value] = GENERATE(table<const char*, const char*, double>({{"newton", "k_r", 1.0},
                                                                                         {"newton", "k_r", 0.6},
                                                                                         {"hertz", "b_H", 0.0},
                                                                                         {"hertz", "b_H", 0.1},
                                                                                         {"linear", "k_S", 0.5},
                                                                                         {"linear", "k_S", 25.0},
                                                                                         {"linear", "k_S", 5000.0}}));
  const HybridSystem system = oscillator(law);
  const bool dissipative = value == 0.6;
  std::vector<Vector> sets;
  LaneCarrier many(system, {}, GENERATE(LaneWidth::widest, LaneWidth::plain_two));
  for (const double eta : {0.55, 0.711, 0.95, 1.4})
    for (const double r : {0.3, 1.0, 2.0}) {
      sets.push_back(parameters(system, {{"eta", eta}, {"r", r}, {parameter, value}}));
      CHECK(many.add_parameters(sets.back()) + 1 == sets.size());
    }
  const auto starts = random_starts(120, 0.3, sets.size());
  constexpr std::size_t periods = 20;
  std::vector<PeriodResult> results;
  many.carry(starts, periods, true, results);
  REQUIRE(results.size() == starts.size() * periods);
  const Difference worst = compare(system, sets, starts, periods, results);
  CHECK(worst.state < 1e-12);
  // Between impacts that lose energy in quick succession the tangent is first large and then small again. A computation with
  // 40 digits attributes half of the largest difference (1.1e-12) to either side. In a contact of stiffness 5000, an event
  // time with error 1e-15 gives a tangent with error 5e-12.
  CHECK(worst.tangent < (dissipative || value == 5000.0 ? 1e-11 : 1e-12));
  CHECK(worst.volume < 1e-12);
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  CHECK(many.carried() == results.size());
  // The Propagator takes over weak and chattering impacts, which are more frequent where impacts lose energy.
  CHECK(static_cast<double>(many.left_over()) < (dissipative ? 0.3 : 0.02) * static_cast<double>(many.carried()));
}

TEST_CASE("lanes of any width give identical bits") {
  const auto [model, xi, r] = GENERATE(table<const char*, double, double>({{"linear", 1.0, 2.0}, {"cantilever", 0.4, 0.3}}));
  const HybridSystem system = make_oscillator(model, GENERATE("newton", "hertz", "linear"));
  const bool tangent = GENERATE(true, false);
  const auto widths = GENERATE(widths_of_processor, plain_widths);
  std::vector<PeriodResult> reference, results;
  for (const LaneWidth width : widths) {
    if (!available(width)) continue;
    LaneCarrier many(system, {}, width);
    for (const double eta : {0.5, 0.70, 0.711, 0.93})
      many.add_parameters(parameters(system, {{"eta", eta}, {"xi", xi}, {"r", r}}));
    many.carry(random_starts(61, r, 4), 11, tangent, results);
    if (reference.empty()) reference = results;
    CHECK(same_bits(results, reference));
  }
}

TEST_CASE("lanes on all threads give identical bits", "[threads]") {
  const char* law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = oscillator(law);
  const auto starts = random_starts(61, 2.0, 3);
  std::vector<PeriodResult> one, several;
  for (std::vector<PeriodResult>* results : {&one, &several}) {
    LaneCarrier many(system);
    for (const double eta : {0.70, 0.711, 0.93}) many.add_parameters(parameters(system, {{"eta", eta}}));
    if (results == &several) many.use_all_threads();
    oneapi::tbb::task_arena(4).execute([&] { many.carry(starts, 11, true, *results); });
  }
  CHECK(same_bits(one, several));
}

TEST_CASE("a motion in lanes does not depend on the other motions", "[sanitized]") {
  const HybridSystem system = oscillator("hertz");
  LaneCarrier many(system);
  many.add_parameters(parameters(system, {{"eta", 0.711}, {"b_H", 0.1}}));
  const auto starts = random_starts(40, 2.0);
  std::vector<PeriodResult> together, alone;
  many.carry(starts, 8, true, together);
  for (std::size_t m = 0; m < starts.size(); ++m) {
    many.carry({starts[m]}, 8, true, alone);
    CHECK(alone[7].x == together[m * 8 + 7].x);
    CHECK(alone[7].Phi == together[m * 8 + 7].Phi);
  }
}

TEST_CASE("a motion in lanes does not depend on the division of its periods between calls") {
  const auto [model, xi, r] = GENERATE(table<const char*, double, double>({{"linear", 1.0, 2.0}, {"cantilever", 0.4, 0.3}}));
  const std::string law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = make_oscillator(model, law);
  LaneCarrier many(system);
  for (const double eta : {0.5, 0.711}) many.add_parameters(parameters(system, {{"eta", eta}, {"xi", xi}, {"r", r}}));
  std::vector<MotionStart> starts = random_starts(100, r, 2);
  constexpr std::size_t periods = 12;
  std::vector<PeriodResult> whole, one;
  many.carry(starts, periods, true, whole);
  std::size_t in_contact = 0;
  for (std::size_t k = 0; k < periods; ++k) {
    many.carry(starts, 1, true, one);
    for (std::size_t m = 0; m < starts.size(); ++m) {
      const PeriodResult& same = whole[m * periods + k];
      if (same.termination != Termination::time) continue;
      CHECK(same_bits({one[m]}, {same}));
      starts[m] = {starts[m].parameters, same.x, same.v};
      in_contact += same.x > r ? 1 : 0;
    }
  }
  CHECK((in_contact > 20) == (law != "newton"));  // periods that end in contact
}

TEST_CASE("lanes leave chattering, sticking and inadmissible motions to the Propagator", "[sanitized]") {
  const HybridSystem system = oscillator("newton");
  const std::vector<Vector> sets = {parameters(system, {{"eta", 0.2}, {"r", 0.3}, {"k_r", 0.5}})};
  LaneCarrier many(system);
  many.add_parameters(sets[0]);
  const std::vector<MotionStart> starts = {{0, 0.0, 0.0}, {0, 0.3, 0.0}, {0, 0.3, -0.5},
                                           {0, 0.3, 0.5}, {0, 0.4, 0.0}, {0, NAN, 0.0}};
  std::vector<PeriodResult> results;
  many.carry(starts, 5, true, results);
  const Difference worst = compare(system, sets, starts, 5, results);
  CHECK(worst.state < 1e-12);
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  CHECK(many.left_over() > 0);
  for (std::size_t k = 0; k < 5; ++k) {
    CHECK(results[4 * 5 + k].termination == Termination::inadmissible_start);
    CHECK(results[5 * 5 + k].termination == Termination::inadmissible_start);
  }
}

TEST_CASE("a contact may begin and end with a period in lanes", "[sanitized]") {
  const HybridSystem system = oscillator(GENERATE("hertz", "linear"));
  const std::vector<Vector> sets = {parameters(system, {{"eta", 0.95}})};
  LaneCarrier many(system);
  many.add_parameters(sets[0]);
  std::vector<MotionStart> starts;
  for (int k = 0; k < 20; ++k) starts.push_back({0, 2.0 + 0.02 * k, 1.5 - 0.15 * k});
  std::vector<PeriodResult> results;
  many.carry(starts, 10, true, results);
  const Difference worst = compare(system, sets, starts, 10, results);
  CHECK(worst.state < 1e-12);
  CHECK(worst.tangent < 1e-12);
  CHECK(worst.impacts == 0);
}

TEST_CASE("lanes carry slow and fast, weakly and strongly damped motions") {
  // Grids of 3 to 700 cells a period, with angles within a cell up to its bound for either frequency.
  const char* law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = oscillator(law);
  std::vector<Vector> sets;
  LaneCarrier many(system);
  for (const double eta : {0.02, 0.25, 0.9, 6.0, 20.0})
    for (const double b : {0.0, 0.3, 0.95}) {
      sets.push_back(parameters(system, {{"eta", eta}, {"b", b}, {"r", 0.4}, {"xi", eta > 1.0 ? 5.0 * eta : 1.0}}));
      many.add_parameters(sets.back());
    }
  const auto starts = random_starts(15 * 8, 0.4, sets.size());
  constexpr std::size_t periods = 4;
  std::vector<PeriodResult> results;
  many.carry(starts, periods, true, results);
  // (At its default tolerance the tangent of the Propagator has errors up to 3e-11 here: 300 time units of contacts a period.)
  FlowOptions fine;
  fine.tolerance = 1e-15;
  const Difference worst = compare(system, sets, starts, periods, results, fine);
  CHECK(worst.state < 1e-12);
  CHECK(worst.tangent < 3e-12);
  // The determinant of a contact is a difference of products of its entries, and damping leaves little of it.
  CHECK(worst.volume < (std::string(law) == "newton" ? 2e-12 : 1e-8));
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  CHECK(many.left_over() < many.carried() / 4);
}

TEST_CASE("strongly damped contacts in lanes agree with the Propagator") {
  // Restitutions down to 0.01 and below. Also masses that are pressed against the stop and creep for whole periods, which
  // reduces a disturbance of the speed by exp(-1000) and more.
  const HybridSystem system = oscillator("hertz");
  const double clearance = GENERATE(0.3, -1.5), eta = clearance > 0.0 ? 1.3 : 0.2;
  std::vector<Vector> sets;
  LaneCarrier many(system);
  for (const double k_H : {0.5, 30.0})
    for (const double loss : {0.0, 50.0, 3000.0, 3e4}) {
      sets.push_back(parameters(system, {{"eta", eta}, {"b", 0.1}, {"r", clearance}, {"k_H", k_H}, {"b_H", loss / k_H}}));
      many.add_parameters(sets.back());
    }
  const auto starts = random_starts(8 * 12, clearance, sets.size());
  std::vector<PeriodResult> results;
  many.carry(starts, 3, true, results);
  const Difference worst = compare(system, sets, starts, 3, results);
  CHECK(worst.state < 1e-12);
  CHECK(worst.tangent < 1e-11);
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  CHECK(many.left_over() < many.carried() / 4);
}

TEST_CASE("a contact may reduce a disturbance to zero and the motion continues", "[sanitized]") {
  // Half of its divergence is -1356: exp(-1356) is below the smallest double.
  const HybridSystem system = oscillator("hertz");
  const std::vector<Vector> sets = {parameters(
      system, {{"b", 0.045717}, {"xi", 4.518903}, {"eta", 0.538887}, {"r", -2.488204}, {"k_H", 6.477598}, {"b_H", 22.776033}})};
  LaneCarrier many(system);
  many.add_parameters(sets[0]);
  const std::vector<MotionStart> starts = {{0, -1.442481, -0.22178}};
  std::vector<PeriodResult> results;
  many.carry(starts, 1, true, results);
  CHECK_FALSE(results[0].by_propagator);
  CHECK(results[0].liouville < -1300.0);
  const Difference worst = compare(system, sets, starts, 1, results);
  CHECK(worst.state < 1e-12);
  CHECK(worst.tangent < 1e-12);
}

TEST_CASE("systems that the lanes do not support are reported", "[sanitized]") {
  FlowOptions general;
  general.kind = FlowKind::general;
  const HybridSystem newton = oscillator("newton"), beam = make_oscillator("cantilever", "newton"),
                     elastic = oscillator("linear");
  CHECK(LaneCarrier::applies(newton, default_parameters(newton.parameters)));
  CHECK_FALSE(LaneCarrier::applies(newton, default_parameters(newton.parameters), general));
  const HybridSystem hertz = oscillator("hertz");
  CHECK(LaneCarrier::applies(hertz, parameters(hertz, {{"k_H", 1e4}, {"b_H", 3.0}})));
  CHECK_FALSE(LaneCarrier::applies(hertz, parameters(hertz, {{"k_H", 1e4}, {"b_H", 3.1}})));
  CHECK_FALSE(LaneCarrier::applies(newton, parameters(newton, {{"b", 1.1}})));
  CHECK(LaneCarrier::applies(newton, parameters(newton, {{"beta", 0.5}})));
  CHECK_FALSE(LaneCarrier::applies(newton, parameters(newton, {{"eta", 0.003}})));  // more cells a period than a grid may have
  CHECK(LaneCarrier::applies(beam, default_parameters(beam.parameters)));
  CHECK(LaneCarrier::applies(elastic, parameters(elastic, {{"k_S", 10000.0}})));
  CHECK_FALSE(LaneCarrier::applies(elastic, parameters(elastic, {{"k_S", 100000.0}})));  // the same
  const HybridSystem two_sided = two_sided_oscillator(true);
  LaneCarrier many(two_sided);
  CHECK_THROWS_WITH(many.add_parameters(default_parameters(two_sided.parameters)),
                    Catch::Contains("is not an oscillator that the lanes know"));
  LaneCarrier none(newton);
  std::vector<PeriodResult> results;
  CHECK_THROWS_WITH(none.carry({{0, 0.0, 0.0}}, 1, false, results), Catch::Contains("0 were added"));
}

TEST_CASE("a period in a single lane consists of flights and impacts", "[sanitized]") {
  const HybridSystem system = oscillator("newton");
  for (const double k_r : {1.0, 0.7, 0.0}) {
    const Vector p = parameters(system, {{"eta", 0.711}, {"k_r", k_r}});
    Propagator propagator(system, p);
    const double T = forcing_period(system, p);
    Transition lane, events;
    Vector x = vector({-0.379, -0.717});
    for (int k = 0; k < 300; ++k) {
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::state}, lane);
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::state, .keep_events = true}, events);
      REQUIRE(lane.termination == Termination::time);
      const double size = 1.0 + events.Phi.norm();
      CHECK((lane.x1 - events.x1).norm() < 1e-12 * size);
      CHECK((lane.Phi - events.Phi).norm() < 1e-12 * size * size);
      CHECK(lane.event_sequence == events.event_sequence);
      CHECK(lane.mode1 == events.mode1);
      if (k_r > 0.0) CHECK(lane.liouville == Approx(events.liouville).margin(1e-12));
      if (lane.event_sequence.empty()) CHECK(lane.liouville == Approx(-2.0 * p[oscillator_parameter::b] * T).margin(1e-12));
      x = lane.x1;
    }
  }
}

TEST_CASE("lanes continue after starts inside the barrier", "[sanitized]") {
  // Fixed: when every lane had such a start, all later motions were left to the Propagator.
  const HybridSystem system = oscillator("newton");
  LaneCarrier many(system, {}, LaneWidth::one);
  const std::size_t set = many.add_parameters(parameters(system, {{"r", 2.0}, {"k_r", 0.8}}));
  std::vector<PeriodResult> results;
  many.carry({{set, 2.5, 0.0}, {set, 3.0, 0.0}, {set, 0.0, 0.0}, {set, 2.1, 0.0}, {set, 1.0, 0.3}}, 1, true, results);
  CHECK(many.left_over() == 3);
  for (const std::size_t outside : {0, 1, 3}) CHECK(results[outside].termination == Termination::inadmissible_start);
  for (const std::size_t inside : {2, 4}) {
    CHECK(results[inside].termination == Termination::time);
    CHECK_FALSE(results[inside].by_propagator);
  }
}

TEST_CASE("a few motions use fewer lanes with the same results", "[sanitized]") {
  const auto [law, periods] = GENERATE(table<const char*, std::size_t>({{"newton", 40}, {"hertz", 20}}));
  const HybridSystem system = oscillator(law);
  const Vector p = parameters(system, {{"r", 1.5}, {"eta", 0.8}});
  for (const std::size_t count : {1, 2, 3, 4, 5, 8, 9, 15, 16, 17}) {  // in one register or two
    LaneCarrier as_wide_as_useful(system), one(system, {}, LaneWidth::one);
    as_wide_as_useful.add_parameters(p);
    one.add_parameters(p);
    std::vector<PeriodResult> a, b;
    as_wide_as_useful.carry(random_starts(count, 1.5), periods, true, a);
    one.carry(random_starts(count, 1.5), periods, true, b);
    REQUIRE(a.size() == b.size());
    INFO(law << ", " << count << " motions");
    for (std::size_t i = 0; i < a.size(); ++i) {
      CHECK(a[i].x == b[i].x);
      CHECK(a[i].v == b[i].v);
      CHECK(a[i].Phi == b[i].Phi);
    }
  }
}

TEST_CASE("lanes record the speeds of impacts and of entries into contact", "[sanitized]") {
  const auto [model, law] = GENERATE(table<const char*, const char*>({{"linear", "newton"},
                                                                      {"linear", "hertz"},
                                                                      {"linear", "linear"},
                                                                      {"cantilever", "newton"},
                                                                      {"cantilever", "hertz"},
                                                                      {"cantilever", "linear"}}));
  const HybridSystem system = make_oscillator(model, law);
  LaneCarrier many(system);
  const bool chatters = law == std::string("newton");
  const Vector p = chatters ? parameters(system, {{"eta", 0.711}, {"r", 0.1}, {"k_r", 0.4}})
                            : parameters(system, {{"eta", 0.711}, {"r", 0.5}});
  many.add_parameters(p);
  const auto starts = random_starts(40, 0.3, 1);
  constexpr std::size_t periods = 6;
  std::vector<PeriodResult> results(starts.size() * periods);
  std::vector<ImpactSpeeds> speeds(starts.size());
  std::vector<MotionRun> runs;
  for (const std::size_t part : {std::size_t{2}, std::size_t{4}}) {  // continues from where it was
    runs.clear();
    for (std::size_t m = 0; m < starts.size(); ++m) {
      const PeriodResult* const last = part == 2 ? nullptr : &results[m * periods + 1];
      const MotionStart start = last ? MotionStart{0, last->x, last->v} : starts[m];
      runs.push_back({start, part, &results[m * periods + (last ? 2 : 0)], m % 5 == 4 ? nullptr : &speeds[m]});
    }
    many.carry(runs, false);
  }
  std::size_t compared = 0;
  Propagator propagator(system, p);
  const double T = forcing_period(system, p);
  for (std::size_t m = 0; m < starts.size(); ++m) {
    INFO(model << ", " << law << ", motion " << m);
    if (results[m * periods].termination != Termination::time) continue;  // it began inside the barrier
    std::vector<double> alone;
    Vector x{{starts[m].x, starts[m].v}};
    Transition one;
    for (std::size_t k = 0; k < periods; ++k) {  // each period from the state in the lanes, so that differences do not grow
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none, .keep_events = true}, one);
      for (const EventRecord& event : one.events)
        if (begins_contact(event.kind)) alone.push_back(event.normal_speed);
      x << results[m * periods + k].x, results[m * periods + k].v;
    }
    const std::vector<double> list = speeds[m].list();
    if (m % 5 == 4) {
      CHECK(list.empty());
      continue;
    }
    REQUIRE(list.size() == alone.size());
    for (std::size_t i = 0; i < list.size(); ++i) CHECK(list[i] == Approx(alone[i]).margin(1e-10));
    compared += list.size();
  }
  CHECK(compared > 100);
  if (chatters) CHECK(many.left_over() > 50);  // their speeds are recorded once
}
