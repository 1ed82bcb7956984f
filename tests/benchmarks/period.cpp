// SPDX-License-Identifier: GPL-3.0-or-later
// The floor, counted in multiplications and additions; what a thousand of them take at the machine's peak, peak.cpp measures.
//
// Newton at eta = 0.711, with its 0.7 impacts a period and the 2x2 sensitivity. Free flight is a turn of two complex numbers, the
// transient and the forcing, of which the second is known at the points of a grid of 20 cells a period: 24 of them looked at on
// the way (5 operations each) and two turns over what lies between them bring the motion near the barrier and away from it; 1.8
// steps with a certificate (a point with its derivatives 45, the Bernstein coefficients of position and speed 85, two sines, two
// cosines and an exponential 100, the step 45) bracket an impact or lead back to the grid; 0.7 impacts have to be met exactly
// (sines and exponential 100, two points 90, two roots 120, the flight's matrix, the saltation, two products and the next flight
// 140). The end of the period is a point of the grid: the flight's matrix, a product, the next flight, 70. Together 150 + 480 +
// 320 + 70 = 1020 operations.
//
// Damped Hertz at eta = 0.711, with its 0.7 contacts a period of 12.8 steps each of the series of order 16 at 1e-12 (9.8 at
// 1e-10). A step in lanes: 12 products of series, of which two are squares, 56 pairs of terms and what is in the middle and at
// the ends (1570 operations, fused or not), 16 sets of sums of 25, ten sums of 17, and some 100 for its length: 2250; 6.9 steps
// are 15500 a period at 1e-10. One contact by itself goes four quantities at once: 460 of such operations a step, and 640 on
// single numbers. The flights add 1000. A table of contacts (for long averages at fixed parameters) has 16 x 16 terms at the most
// in place of the steps: some 800 fused operations with the sensitivity.
//
// The cantilever with Newton's law, eta = 0.554, has 1.8 impacts a period and 14.8 steps at 1e-10. A step in lanes: the series of
// order 16 with its tangent 810 (570 of them fused), its sums 120, that the barrier is not reached 140. An impact: the series once
// more, its root and sums, the saltation, 1100. Together 17800.
//
// How far from it: see the table, rows peak/lanes=N and peak/fused-lanes=N (operations on N numbers at once) and period/*. On an
// AMD EPYC (Zen 5, TSC 2.6 GHz) a thousand single operations take 141 ns one at a time, 71 in SSE2, 36 in AVX2, 22 in AVX-512, a
// thousand fused ones 244, 62 (AVX2), 37 (AVX-512). One lane of Newton has its floor at 144 ns and takes 169 with one period at a
// call; eight lanes at 22 ns and 64 (on average five of them have something to do). One lane of damped Hertz at 1e-10 has its
// floor at 6.9 x (460 x 0.25 + 640 x 0.14) ns and the flights, 1.6 us, and takes 2.2; eight lanes at 0.6 us, which is what they
// take: some of their additions find a place beside the fused operations. Eight lanes of the cantilever have theirs at 0.58 us, and
// take 0.56 to 0.58.
//
// What does a forcing period cost, with its 2x2 sensitivity? Over 200 periods on the attractor, every solver at the loosest
// tolerance that delivers 1e-10. `miscounted`: of 200 runs next to grazing, those with a wrong number of impacts at that
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

/// The 200 periods side by side. (The runs next to grazing are no whole periods from phase 0: not for the lanes.)
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
    if (graze::ManyMotions::applies(make_system(p), make_parameters(p)))
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
