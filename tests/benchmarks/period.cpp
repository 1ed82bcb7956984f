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
// Damped Hertz at eta = 0.711, with its 0.7 contacts a period: 12.8 steps of the series of order 16 at 1e-12 (9.8 at 1e-10), in
// each 12 products of series of 136 terms, two operations a term, 16 sets of sums of 45 and ten sums of 32: 4300 operations,
// 38000 a period (30000 at 1e-10). The flights add 1000. Where multiplication and addition are fused, four quantities at once, a
// step is 460 of those and 640 on single numbers. A table of contacts (for long averages at fixed parameters) has 16 x 16 terms
// at the most in place of 12.8 x 4300 operations: some 1500 with the sensitivity.
//
// How far from it: see the table, rows peak/lanes=N (operations on N numbers at once) and period/*; on an AMD EPYC of 2.6 GHz a
// thousand operations take 172 ns one at a time, 86 in SSE2, 46 in AVX2, 34 in AVX-512. One lane of Newton, which goes one at a
// time, has its floor at 175 ns and takes 207 with 32 periods at a call, 255 with one; eight lanes at 35 ns and 80 (on average
// five of them have something to do), 110 with one period at a call. One lane of damped Hertz at 1e-10 has its floor at 9.8 x
// (460 x 0.19 + 640 x 0.17) ns and the flights, 2.1 us, and takes 2.8; eight lanes at 1.1 us and 1.3.
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
