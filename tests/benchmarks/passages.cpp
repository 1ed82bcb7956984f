// SPDX-License-Identifier: GPL-3.0-or-later
// Cost of a flight (from one impact through the next), of a passage through contact, and of an impact by itself. All include
// the 2x2 sensitivity, start from states on the attractor, and use the tolerances that give 1e-10 over a period.
#include "solvers.hpp"

#include <graze/lib/motion/trajectory.hpp>

namespace benchmarks {
namespace {

using namespace graze;

/// States immediately after the events of a kind.
std::vector<HybridState> departures(const Problem& p, EventKind kind) {
  const HybridSystem system = make_system(p);
  const Start& first = attractor(p).front();
  const Trajectory run = simulate(system, make_parameters(p), 0.0, Vector{{first.x, first.v}}, {.t_end = 200.0 * p.period()});
  std::vector<HybridState> out;
  for (const EventRecord& event : run.events)
    if (event.kind == kind) out.push_back({event.t, event.x_plus, event.mode_plus});
  return out;
}

void passages_of_graze(benchmark::State& state, const Problem& p, EventKind kind, double tolerance) {
  const std::vector<HybridState> starts = departures(p, kind);
  Graze solver(p, tolerance);
  HybridState z;
  for (auto _ : state)
    for (const HybridState& start : starts) {
      z = start;
      if (solver.propagator().step(z, start.t + 5.0 * p.period(), Sensitivity::state) != StepEnd::event)
        return state.SkipWithError("no event");
      benchmark::DoNotOptimize(z.x);
    }
  per_item(state, starts.size());
}

template <Law law, class Make>
void passages_of_baseline(benchmark::State& state, const Problem& p, EventKind kind, const Make& make, double tolerance) {
  const std::vector<HybridState> starts = departures(p, kind);
  auto solver = make(tolerance);
  for (auto _ : state)
    for (const HybridState& start : starts) {
      baselines::State<6> u = baselines::start<6>(start.x[0], start.x[1]);
      const baselines::Stretch stretch = solver.stepper().carry(kind == EventKind::enter, start.t, start.t + 5.0 * p.period(), u);
      if (!stretch.event) return state.SkipWithError("no event");
      if constexpr (law == Law::newton) baselines::strike(p.p, stretch.t, u);
      benchmark::DoNotOptimize(u);
    }
  per_item(state, starts.size());
}

template <Law law> void register_passages(const std::string& question, const Problem& p, EventKind kind) {
  const auto name = [&](const std::string& solver) { return question + "/" + p.name + "/" + solver; };
  benchmark::RegisterBenchmark(name("graze").c_str(), [p, kind](benchmark::State& state) {
    const auto make = [p](double tolerance) { return Graze(p, tolerance); };
    const Accuracy& known = tuning(p, "graze", make);
    passages_of_graze(state, p, kind, known.tolerance);
    report(state, known);
  });
  with_baselines<law>(p, [&](const std::string& solver, const auto& make) {
    if (solver.ends_with("-signs")) return;
    benchmark::RegisterBenchmark(name(solver).c_str(), [p, kind, solver, make](benchmark::State& state) {
      const Accuracy& known = tuning(p, solver, make);
      passages_of_baseline<law>(state, p, kind, make, known.tolerance);
      report(state, known);
    });
  });
}

/// An impact by itself: from the state before it, on the barrier. By hand it is a dozen floating-point operations.
void impact_of_graze(benchmark::State& state) {
  const Problem& p = problem("newton-elastic");
  Graze solver(p, 1e-13);
  const HybridState before{1.0, Vector{{p.p.r, 0.7}}, 0};
  HybridState z;
  for (auto _ : state) {
    z = before;
    if (solver.propagator().step(z, 2.0, Sensitivity::state) != StepEnd::event) return state.SkipWithError("no event");
    benchmark::DoNotOptimize(solver.propagator().record().saltation.S.data());
  }
  per_item(state, 1);
}
void impact_by_hand(benchmark::State& state) {
  const Problem& p = problem("newton-elastic");
  baselines::State<6> u;
  for (auto _ : state) {
    u = baselines::start<6>(p.p.r, 0.7);
    benchmark::DoNotOptimize(u);
    baselines::strike(p.p, 1.0, u);
    benchmark::DoNotOptimize(u);
  }
  per_item(state, 1);
}

const bool registered = [] {
  register_passages<Law::newton>("flight", problem("newton-elastic"), EventKind::impact);
  register_passages<Law::newton>("flight", problem("beam-newton"), EventKind::impact);
  register_passages<Law::hertz>("contact", problem("hertz-damped"), EventKind::enter);
  register_passages<Law::hertz>("contact", problem("hertz-undamped"), EventKind::enter);
  register_passages<Law::hertz>("contact", problem("beam-hertz"), EventKind::enter);
  benchmark::RegisterBenchmark("impact/newton-elastic/graze", impact_of_graze);
  benchmark::RegisterBenchmark("impact/newton-elastic/by-hand", impact_by_hand);
  return true;
}();

}  // namespace
}  // namespace benchmarks
