// SPDX-License-Identifier: GPL-3.0-or-later
// Cantilevers (cubic stiffness beta x^3) side by side in SIMD lanes. Each motion is compared with the Propagator, both with
// the series of the cubic spring and with the general flow.
#include "support/lane_differences.hpp"

#include <graze/lib/models/oscillator.hpp>

#include <catch2/catch.hpp>

using namespace graze;
using namespace graze::support;

namespace {

HybridSystem cantilever(const char* law) { return make_oscillator("cantilever", law); }

struct Row {
  const char* law;
  const char* parameter;
  double value;
};

}  // namespace

TEST_CASE("lanes and Propagator agree for cantilevers", "[sanitized]") {
  const Row row =
      GENERATE(Row{"newton", "k_r", 1.0}, Row{"newton", "k_r", 0.6}, Row{"hertz", "b_H", 0.0}, Row{"hertz", "b_H", 0.1},
               Row{"linear", "k_S", 0.5}, Row{"linear", "k_S", 25.0}, Row{"linear", "k_S", 5000.0});
  const HybridSystem system = cantilever(row.law);
  std::vector<Vector> sets;
  LaneCarrier many(system, {}, GENERATE(LaneWidth::widest, LaneWidth::plain_two));
  for (const double eta : {0.4, 0.711, 1.4})
    for (const double beta : {-0.02, 0.3, 36.0 / 35.0}) {
      sets.push_back(parameters(system, {{"eta", eta}, {"r", 0.3}, {"beta", beta}, {"xi", 0.4}, {row.parameter, row.value}}));
      many.add_parameters(sets.back());
    }
  const auto starts = random_starts(54, 0.3, sets.size());
  constexpr std::size_t periods = 12;
  std::vector<PeriodResult> results;
  many.carry(starts, periods, true, results);
  const Difference worst = compare(system, sets, starts, periods, results);
  const bool dissipative = row.value == 0.6;
  INFO(row.law << ", " << row.parameter << " = " << row.value);
  CHECK(worst.state < 1e-12);
  CHECK(worst.tangent < (dissipative || row.value == 5000.0 ? 1e-11 : 1e-12));
  CHECK(worst.volume < 1e-11);
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  int impacts = 0;
  for (const PeriodResult& one : results) impacts += one.impacts;
  CHECK(impacts > 300);
  CHECK(static_cast<double>(many.left_over()) < (dissipative ? 0.3 : 0.05) * static_cast<double>(many.carried()));
}

TEST_CASE("lanes and general flow agree for cantilevers", "[sanitized]") {
  const char* law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = cantilever(law);
  const Vector p = parameters(system, {{"eta", 0.554}, {"b", 0.026}, {"xi", 0.08}, {"r", 0.079}});
  LaneCarrier many(system);
  many.add_parameters(p);
  const auto starts = random_starts(8, 0.079);
  std::vector<PeriodResult> results;
  many.carry(starts, 4, true, results);
  FlowOptions options;
  options.kind = FlowKind::general;
  const Difference worst = compare(system, {p}, starts, 4, results, options);
  CHECK(worst.state < 1e-10);
  CHECK(worst.tangent < 1e-9);
  CHECK(worst.impacts == 0);
}

TEST_CASE("lanes miss no impact of a cantilever near grazing", "[sanitized]") {
  // The turning point of a free motion from rest. The barrier lies just beyond it, or just short of it.
  const char* law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = cantilever(law);
  const Vector far = parameters(system, {{"eta", 0.8}, {"xi", 0.3}, {"r", 50.0}});
  Propagator free(system, far);
  const double T = forcing_period(system, far);
  double highest = -1.0;
  Transition path;
  for (int k = 1; k <= 2000; ++k) {
    carry(free, 0.0, T * k / 2000.0, vector({-0.5, 0.1}), {.sensitivity = Sensitivity::none}, path);
    highest = std::max(highest, path.x1[0]);
  }
  std::vector<Vector> sets;
  std::vector<MotionStart> starts;
  for (const double distance : {1e-2, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-11})
    for (const double side : {-1.0, 1.0}) {
      Vector p = far;
      p[oscillator_parameter::r] = highest + side * distance;
      sets.push_back(p);
      for (int k = 0; k < 12; ++k) starts.push_back({sets.size() - 1, -0.5 - 1e-7 * k * k, 0.1 - 1e-9 * k});
    }
  check_near_grazing(system, sets, starts, 2);
}

TEST_CASE("linear oscillators and cantilevers share the lanes", "[sanitized]") {
  const HybridSystem system = cantilever("newton");
  std::vector<Vector> sets;
  LaneCarrier many(system);
  for (const double beta : {0.5, 0.0, 1.0, 0.0}) {
    sets.push_back(parameters(system, {{"eta", 0.7}, {"beta", beta}, {"xi", 0.4}, {"r", 0.3}}));
    many.add_parameters(sets.back());
  }
  const auto starts = random_starts(32, 0.3, sets.size());
  std::vector<PeriodResult> results;
  many.carry(starts, 9, true, results);
  const Difference worst = compare(system, sets, starts, 9, results);
  CHECK(worst.state < 1e-12);
  CHECK(worst.tangent < 1e-12);
  CHECK(worst.impacts == 0);
  CHECK(many.left_over() < many.carried() / 20);
}

TEST_CASE("lanes leave chattering, escaping and inadmissible cantilevers to the Propagator", "[sanitized]") {
  const HybridSystem system = cantilever("newton");
  const std::vector<Vector> sets = {parameters(system, {{"eta", 0.2}, {"r", 0.3}, {"k_r", 0.5}}),
                                    parameters(system, {{"eta", 0.7}, {"beta", -1.0}, {"r", 0.3}})};
  LaneCarrier many(system);
  for (const Vector& p : sets) many.add_parameters(p);
  const std::vector<MotionStart> starts = {{0, 0.0, 0.0}, {0, 0.3, 0.0}, {0, 0.3, -0.5}, {0, 0.3, 0.5},
                                           {0, 0.4, 0.0}, {0, NAN, 0.0}, {1, -3.0, -1.0}};
  std::vector<PeriodResult> results;
  many.carry(starts, 3, true, results);
  const Difference worst = compare(system, sets, starts, 3, results);
  CHECK(worst.state < 1e-12);
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  CHECK(many.left_over() > 0);
  CHECK(results[3 * 4].termination == Termination::inadmissible_start);
  CHECK(results[3 * 5].termination == Termination::inadmissible_start);
  CHECK(results[3 * 6].termination == Termination::escape);
}

TEST_CASE("lanes report too many impacts in a period of a cantilever", "[sanitized]") {
  // Fixed: the lanes carried a period with more impacts than the Propagator allows, however long it took.
  using Values = std::vector<std::pair<const char*, double>>;
  const auto [law, values, x] = GENERATE(table<const char*, Values, double>(
      {{"newton", Values{{"b", 0.01}, {"beta", 1e3}, {"xi", 0.08}, {"eta", 0.05}, {"r", -3.0}, {"k_r", 1.0}}, -3.2},
       {"hertz", Values{{"b", 0.01}, {"beta", 1e3}, {"xi", 1.0}, {"eta", 0.05}, {"r", 2.0}, {"k_H", 1e5}, {"b_H", 0.0}}, -20.0},
       {"linear", Values{{"b", 0.0}, {"beta", 1e3}, {"xi", 5.0}, {"eta", 0.02}, {"r", -0.5}, {"k_S", 1e5}}, -3.0}}));
  const HybridSystem system = cantilever(law);
  LaneCarrier many(system);
  many.add_parameters(parameters(system, values));
  std::vector<PeriodResult> results;
  many.carry({{0, x, 1.0}, {0, x, 0.0}}, 2, true, results);
  for (const PeriodResult& one : results) CHECK(one.termination == Termination::event_limit);
}
