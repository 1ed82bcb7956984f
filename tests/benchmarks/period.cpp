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

const bool registered = [] {
  for (const Problem& p : problems())
    with_solvers(p, [&](const std::string& name, const auto& make) {
      benchmark::RegisterBenchmark(("period/" + p.name + "/" + name).c_str(),
                                   [p, name, make](benchmark::State& state) { periods(state, p, name, make); });
    });
  return true;
}();

}  // namespace
}  // namespace benchmarks
