// SPDX-License-Identifier: GPL-3.0-or-later
// Cantilevers (beta x^3) side by side in SIMD lanes, against the same motions one by one, by their own series and by the general
// flow, and against themselves in fewer lanes.
#include "support/lane_differences.hpp"
#include "support/lane_widths.hpp"

#include <graze/lib/oscillator.hpp>

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

TEST_CASE("lanes carry cantilevers as the Propagator does") {
  const Row row =
      GENERATE(Row{"newton", "k_r", 1.0}, Row{"newton", "k_r", 0.6}, Row{"hertz", "b_H", 0.0}, Row{"hertz", "b_H", 0.1},
               Row{"linear", "k_S", 0.5}, Row{"linear", "k_S", 25.0}, Row{"linear", "k_S", 5000.0});
  const HybridSystem system = cantilever(row.law);
  std::vector<Vector> parameters;
  ManyMotions many(system, {}, GENERATE(LaneWidth::widest, LaneWidth::plain_two));
  for (const double eta : {0.4, 0.711, 1.4})
    for (const double beta : {-0.02, 0.3, 36.0 / 35.0}) {
      parameters.push_back(with(system, {{"eta", eta}, {"r", 0.3}, {"beta", beta}, {"xi", 0.4}, {row.parameter, row.value}}));
      many.add_parameters(parameters.back());
    }
  const auto starts = random_starts(54, 0.3, parameters.size());
  constexpr std::size_t periods = 12;
  std::vector<PeriodResult> results;
  many.carry(starts, periods, true, results);
  const Difference worst = compare(system, parameters, starts, periods, results);
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

TEST_CASE("lanes carry cantilevers as the general flow does") {
  const char* law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = cantilever(law);
  const Vector p = with(system, {{"eta", 0.554}, {"b", 0.026}, {"xi", 0.08}, {"r", 0.079}});
  ManyMotions many(system);
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

TEST_CASE("cantilevers in lanes of any width give the same to the last bit") {
  const char* law = GENERATE("newton", "hertz", "linear");
  const bool tangent = GENERATE(true, false);
  const auto widths = GENERATE(widths_of_processor, plain_widths);
  const HybridSystem system = cantilever(law);
  std::vector<PeriodResult> reference, results;
  for (const LaneWidth width : widths) {
    if (!available(width)) continue;
    ManyMotions many(system, {}, width);
    for (const double eta : {0.5, 0.711, 0.93}) many.add_parameters(with(system, {{"eta", eta}, {"xi", 0.4}, {"r", 0.3}}));
    many.carry(random_starts(29, 0.3, 3), 7, tangent, results);
    if (reference.empty()) reference = results;
    CHECK(same_bits(results, reference));
  }
}

TEST_CASE("lanes miss no impact of a cantilever next to grazing") {
  // The turning point of a free motion from rest, and the barrier just beyond it, and just within.
  const char* law = GENERATE("newton", "hertz", "linear");
  const HybridSystem system = cantilever(law);
  const Vector far = with(system, {{"eta", 0.8}, {"xi", 0.3}, {"r", 50.0}});
  Propagator free(system, far);
  const double T = forcing_period(system, far);
  double highest = -1.0;
  Transition path;
  for (int k = 1; k <= 2000; ++k) {
    carry(free, 0.0, T * k / 2000.0, vector({-0.5, 0.1}), {.sensitivity = Sensitivity::none}, path);
    highest = std::max(highest, path.x1[0]);
  }
  std::vector<Vector> parameters;
  std::vector<MotionStart> starts;
  ManyMotions many(system);
  for (const double distance : {1e-2, 1e-4, 1e-5, 1e-6, 1e-7, 1e-9, 1e-11})
    for (const double side : {-1.0, 1.0}) {
      Vector p = far;
      p[oscillator_parameter::r] = highest + side * distance;
      parameters.push_back(p);
      const std::size_t set = many.add_parameters(p);
      for (int k = 0; k < 12; ++k) starts.push_back({set, -0.5 - 1e-7 * k * k, 0.1 - 1e-9 * k});
    }
  std::vector<PeriodResult> results;
  many.carry(starts, 2, true, results);
  int impacts = 0;
  for (const PeriodResult& one : results) impacts += one.impacts;
  CHECK(impacts > 50);
  const Difference worst = compare(system, parameters, starts, 2, results);
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  CHECK(worst.state < 1e-12);
}

TEST_CASE("linear oscillators and cantilevers share the lanes") {
  const HybridSystem system = cantilever("newton");
  std::vector<Vector> parameters;
  ManyMotions many(system);
  for (const double beta : {0.5, 0.0, 1.0, 0.0}) {
    parameters.push_back(with(system, {{"eta", 0.7}, {"beta", beta}, {"xi", 0.4}, {"r", 0.3}}));
    many.add_parameters(parameters.back());
  }
  const auto starts = random_starts(32, 0.3, parameters.size());
  std::vector<PeriodResult> results;
  many.carry(starts, 9, true, results);
  const Difference worst = compare(system, parameters, starts, 9, results);
  CHECK(worst.state < 1e-12);
  CHECK(worst.tangent < 1e-12);
  CHECK(worst.impacts == 0);
  CHECK(many.left_over() < many.carried() / 20);
}

TEST_CASE("a cantilever that chatters, runs away or starts inside is left to the Propagator") {
  const HybridSystem system = cantilever("newton");
  const std::vector<Vector> parameters = {with(system, {{"eta", 0.2}, {"r", 0.3}, {"k_r", 0.5}}),
                                          with(system, {{"eta", 0.7}, {"beta", -1.0}, {"r", 0.3}})};
  ManyMotions many(system);
  for (const Vector& p : parameters) many.add_parameters(p);
  const std::vector<MotionStart> starts = {{0, 0.0, 0.0}, {0, 0.3, 0.0}, {0, 0.3, -0.5}, {0, 0.3, 0.5},
                                           {0, 0.4, 0.0}, {0, NAN, 0.0}, {1, -3.0, -1.0}};
  std::vector<PeriodResult> results;
  many.carry(starts, 3, true, results);
  const Difference worst = compare(system, parameters, starts, 3, results);
  CHECK(worst.state < 1e-12);
  CHECK(worst.impacts == 0);
  CHECK(worst.other_endings == 0);
  CHECK(many.left_over() > 0);
  CHECK(results[3 * 4].termination == Termination::inadmissible_start);
  CHECK(results[3 * 5].termination == Termination::inadmissible_start);
  CHECK(results[3 * 6].termination == Termination::integration_failed);
}

TEST_CASE("more impacts in a period than are allowed are told of cantilevers in lanes, too") {
  // Fixed: lanes carried what the Propagator refuses, and worked on it for as long as it lasted.
  using Values = std::vector<std::pair<const char*, double>>;
  const auto [law, values, x] = GENERATE(table<const char*, Values, double>(
      {{"newton", Values{{"b", 0.01}, {"beta", 1e3}, {"xi", 0.08}, {"eta", 0.05}, {"r", -3.0}, {"k_r", 1.0}}, -3.2},
       {"hertz", Values{{"b", 0.01}, {"beta", 1e3}, {"xi", 1.0}, {"eta", 0.05}, {"r", 2.0}, {"k_H", 1e5}, {"b_H", 0.0}}, -20.0},
       {"linear", Values{{"b", 0.0}, {"beta", 1e3}, {"xi", 5.0}, {"eta", 0.02}, {"r", -0.5}, {"k_S", 1e5}}, -3.0}}));
  const HybridSystem system = cantilever(law);
  ManyMotions many(system);
  many.add_parameters(with(system, values));
  std::vector<PeriodResult> results;
  many.carry({{0, x, 1.0}, {0, x, 0.0}}, 2, true, results);
  for (const PeriodResult& one : results) CHECK(one.termination == Termination::event_limit);
}
