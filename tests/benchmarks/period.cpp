// SPDX-License-Identifier: GPL-3.0-or-later
// The lower bound of the cost of a forcing period, counted in multiplications and additions; peak.cpp measures the time of a
// thousand of them at the machine's peak.
//
// Newton at eta = 0.711, with 0.7 impacts a period and the 2x2 sensitivity. Free flight is a rotation of two complex numbers,
// the transient and the forcing. The forcing is known at the points of a grid of 20 cells a period. The costs are:
// - 1.4 marches, each over as many cells as are clear of the barrier: 24 tests (5 operations each) and one rotation over the
//   cells between (70);
// - where that is not certain, 0.2 steps with a certificate (a point with its derivatives 45, the Bernstein coefficients of
//   position and speed 85, two sines, two cosines and an exponential 100, the step 45);
// - 0.7 exact impacts (sines and exponential 100, two points 90, two roots 120, the matrix of the flight, the saltation, two
//   products and the next flight 140);
// - the end of the period, which is a point of the grid: the matrix of the flight, a product, the next flight, 70.
// The sum is 270 + 50 + 320 + 70 = 710 operations.
//
// Damped Hertz at eta = 0.711, with 0.7 contacts a period. Each contact has 12.8 steps of the series of order 16 at 1e-12 (9.8
// at 1e-10). A step in lanes has 11 products of series, of which two are squares, 136 terms each (1370 operations), 36 more an
// order (580), ten sums of 16, and some 80 for its length: 2190, nearly all fused. 6.9 steps are 15100 a period at 1e-10. A
// single contact processes four quantities at once: 460 such operations a step, and 640 on single numbers. The flights add
// 1000. A table of contacts (for long averages at fixed parameters) has at most 16 x 16 terms in place of the steps: some 800
// fused operations with the sensitivity.
//
// The cantilever with Newton's law, eta = 0.554, has 1.8 impacts a period and 14.8 steps at 1e-10. A step in lanes: the series
// of order 16 with its tangent 810 (570 of them fused), its sums 120, the test that the barrier is not reached 140. An impact:
// the series once more, its root and sums, the saltation, 1100. Together 17800.
//
// For the distance from this bound see the table, rows peak/lanes=N and peak/fused-lanes=N (operations on N numbers at once)
// and period/*. All times below are per period.
// On an AMD EPYC of 2023 (Zen 4, TSC 2.6 GHz, whose AVX-512 is as fast as AVX2) a thousand single operations take 87 ns one at
// a time, 43 in SSE2, 21 in AVX2 and in AVX-512; a thousand fused ones take 138, 34 and 34. For one lane of Newton the bound
// is 62 ns and the time 280. For eight lanes they are 15 ns and 92 (on average five of the lanes are busy). For one lane of
// damped Hertz at 1e-10 the bound is 6.9 x (460 x 0.14 + 640 x 0.09) ns plus the flights, 0.9 us, and the time 2.9: each order
// of a series waits for the one before. For eight lanes the bound is 15100 x 0.034 ns plus the flights, 0.54 us, and the time
// 0.87: on average 7.3 of 8 lanes are in contact in a step, and registers wait for loads, once for two orders. For eight lanes
// of the cantilever the bound is 0.6 us and the time 0.84, with 7.3 lanes in flight.
//
// On an EPYC of 2025 (Zen 5, with AVX-512 at full width) a thousand single operations take 67 ns one at a time, 34 in SSE2, 17
// in AVX2 and 8.4 in AVX-512; fused ones 118, 29 and 15. By the same counts the bound for one lane of Newton is 48 ns and the
// time 180, for eight lanes 6.0 and 68. For one lane of damped Hertz they are 0.73 us and 2.2, for eight 0.23 and 0.51; for
// eight of the cantilever 0.26 and 0.52.
//
// Measured: the cost of a forcing period with its 2x2 sensitivity, over 200 periods on the attractor. Every solver uses the
// loosest tolerance that gives 1e-10. `miscounted`: number of the 200 runs near grazing with a wrong number of impacts at that
// tolerance.
#include "solvers.hpp"

namespace benchmarks {
namespace {

template <class Make> void periods(benchmark::State& state, const Problem& p, const std::string& name, const Make& make) {
  const Accuracy& known = tuning(p, name, make);
  auto solver = make(known.tolerance);
  const std::vector<Start>& starts = attractor(p);
  for (auto _ : state)
    for (const Start& start : starts) benchmark::DoNotOptimize(solver.period(start));
  per_item(state, starts.size());
  report(state, known);
  state.counters["wrong"] = known.miscounted;
  state.counters["miscounted"] = miscounted(p, name, make);
}

/// The 200 periods side by side. (The runs near grazing are not whole periods from phase 0 and therefore not for the lanes.)
void lanes(benchmark::State& state, const Problem& p) {
  const Accuracy& known = tuning(p, "graze-lanes", [&](double tolerance) { return GrazeLanes(p, tolerance); });
  GrazeLanes solver(p, known.tolerance);
  const std::vector<Start>& starts = attractor(p);
  for (auto _ : state) benchmark::DoNotOptimize(solver.periods(starts).data());
  per_item(state, starts.size());
  report(state, known);
  state.counters["wrong"] = known.miscounted;
}

const bool registered = [] {
  for (const Problem& p : problems()) {
    if (graze::LaneCarrier::applies(make_system(p), make_parameters(p)))
      benchmark::RegisterBenchmark(("period/" + p.name + "/graze-lanes").c_str(),
                                   [p](benchmark::State& state) { lanes(state, p); });
    with_solvers(p, [&](const std::string& name, const auto& make) {
      benchmark::RegisterBenchmark(("period/" + p.name + "/" + name).c_str(),
                                   [p, name, make](benchmark::State& state) { periods(state, p, name, make); });
    });
  }
  return true;
}();

}  // namespace
}  // namespace benchmarks
