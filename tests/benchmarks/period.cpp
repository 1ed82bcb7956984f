// SPDX-License-Identifier: GPL-3.0-or-later
// The floor, counted in multiplications and additions; what a thousand of them take at the machine's peak, peak.cpp measures.
//
// Newton at eta = 0.711, with its 0.7 impacts a period and the 2x2 sensitivity. Free flight is a turn of two complex numbers, the
// transient and the forcing, of which the second is known at the points of a grid of 20 cells a period: 1.4 marches, each over as
// many cells as are clear of the barrier, look at 24 of them (5 operations each) and turn over what lies between (70); where that
// is not sure, 0.2 steps with a certificate (a point with its derivatives 45, the Bernstein coefficients of position and speed
// 85, two sines, two cosines and an exponential 100, the step 45) lead on; 0.7 impacts have to be met exactly (sines and
// exponential 100, two points 90, two roots 120, the flight's matrix, the saltation, two products and the next flight 140). The
// end of the period is a point of the grid: the flight's matrix, a product, the next flight, 70. Together 270 + 50 + 320 + 70 =
// 710 operations.
//
// Damped Hertz at eta = 0.711, with its 0.7 contacts a period of 12.8 steps each of the series of order 16 at 1e-12 (9.8 at
// 1e-10). A step in lanes: 11 products of series, of which two are squares, 136 terms each (1370 operations), 36 more an order
// (580), ten sums of 16, and some 80 for its length: 2190, nearly all fused; 6.9 steps are 15100 a period at 1e-10. One contact
// by itself goes four quantities at once: 460 of such operations a step, and 640 on single numbers. The flights add 1000. A table
// of contacts (for long averages at fixed parameters) has 16 x 16 terms at the most in place of the steps: some 800 fused
// operations with the sensitivity.
//
// The cantilever with Newton's law, eta = 0.554, has 1.8 impacts a period and 14.8 steps at 1e-10. A step in lanes: the series of
// order 16 with its tangent 810 (570 of them fused), its sums 120, that the barrier is not reached 140. An impact: the series
// once more, its root and sums, the saltation, 1100. Together 17800.
//
// How far from it: see the table, rows peak/lanes=N and peak/fused-lanes=N (operations on N numbers at once) and period/*. On an
// AMD EPYC of 2023 (Zen 4, TSC 2.6 GHz, whose AVX-512 does at once what AVX2 does) a thousand single operations take 87 ns one at
// a time, 43 in SSE2, 21 in AVX2 and in AVX-512, a thousand fused ones 138, 34 and 34. One lane of Newton has its floor at 62 ns
// and takes 280; eight lanes at 15 ns and 92 (on average five of them have something to do). One lane of damped Hertz at 1e-10
// has its floor at 6.9 x (460 x 0.14 + 640 x 0.09) ns and the flights, 0.9 us, and takes 2.9: each order of a series waits for
// the one before. Eight lanes have it at 15100 x 0.034 ns and the flights, 0.54 us, and take 0.87: 7.3 of 8 lanes on average are
// in contact when a step is taken, and registers wait to be loaded, once for two orders. Eight lanes of the cantilever have
// theirs at 0.6 us, and take 0.84, 7.3 of them in flight.
//
// On an EPYC of 2025 (Zen 5, with AVX-512 at full width) a thousand single operations take 67 ns one at a time, 34 in SSE2, 17 in
// AVX2 and 8.4 in AVX-512, fused ones 118, 29 and 15. By the same counts one lane of Newton has its floor at 48 ns and takes 180,
// eight at 6.0 and take 68; one lane of damped Hertz at 0.73 us and takes 2.2, eight at 0.23 and take 0.51; eight of the
// cantilever at 0.26 and take 0.52.
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
