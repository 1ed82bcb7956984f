// SPDX-License-Identifier: GPL-3.0-or-later
// The floor: (stated here: what an implementation by hand of the same motion costs at least, and how far graze is from it.)
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
