// SPDX-License-Identifier: GPL-3.0-or-later
// Cost of a forcing period with its sensitivity as a function of the number of impacts in it. (Period n of an orbit:
// orbits.cpp; number of states: chain.cpp.)
#include "solvers.hpp"

namespace benchmarks {
namespace {

using namespace graze;

/// The elastic stop at x = 0: for half of the forcing period the force presses the mass against it, and the mass bounces.
/// Slower forcing gives more impacts.
Problem pressed(double eta) {
  Problem p = problem("newton-elastic");
  p.name = "pressed, eta = " + std::to_string(eta);
  p.p.eta = eta;
  p.p.r = 0.0;
  p.x = -1.0;
  p.v = 0.0;
  return p;
}

template <class Make> void impacts(benchmark::State& state, const Problem& p, const Make& make, double tolerance) {
  auto solver = make(tolerance);
  const std::vector<Start>& starts = attractor(p);
  int struck = 0;
  for (const Start& start : starts) struck += solver.period(start).impacts;
  for (auto _ : state)
    for (const Start& start : starts) benchmark::DoNotOptimize(solver.period(start));
  per_item(state, starts.size());
  state.counters["impacts"] = static_cast<double>(struck) / static_cast<double>(starts.size());
}

const bool registered = [] {
  for (const double eta : {1.0, 0.5, 0.25, 0.125, 0.0625}) {
    const Problem p = pressed(eta);
    with_solvers(p, [&](const std::string& name, const auto& make) {
      if (name != "graze" && name != "gsl-rk8pd" && name != "boost-dopri5") return;
      std::string label = std::to_string(eta);
      label.erase(label.find_last_not_of('0') + 1);
      benchmark::RegisterBenchmark(("impacts/eta=" + label + "/" + name).c_str(), [p, name, make](benchmark::State& state) {
        impacts(state, p, make, tuning(p, name, make).tolerance);
      });
    });
  }
  return true;
}();

}  // namespace
}  // namespace benchmarks
