// SPDX-License-Identifier: GPL-3.0-or-later
// What a forcing period costs with the 2x2 sensitivity: the fast flows against the general GSL flow in the same run, on a chaotic
// motion (eta = 0.711), at equal delivered accuracy: both flows run at their default tolerance, and the counter `difference` gives the
// largest difference of their states over a period. And what `continue` costs from 0.95 to 0.90 with the period doubling located.
#include <graze/continuation/continuation.hpp>
#include <graze/lib/oscillator.hpp>
#include <graze/lib/transition.hpp>

#include <benchmark/benchmark.h>

using namespace graze;

namespace {

constexpr int periods = 200;
const TransitionOptions with_tangent{.sensitivity = Sensitivity::state};

struct Motion {
  HybridSystem system;
  Vector p;
  double T;
  std::vector<Vector> starts;  ///< states at phase 0 on the attractor
};

Motion chaotic(const char* law) {
  Motion motion{make_oscillator("linear", law), {}, 0.0, {}};
  motion.p = default_parameters(motion.system.parameters);
  motion.p[oscillator_parameter::eta] = 0.711;
  if (std::string(law) == "hertz") motion.p[oscillator_parameter::law + 1] = 0.1;  // b_H
  motion.T = forcing_period(motion.system, motion.p);
  Propagator propagator(motion.system, motion.p);
  Transition transition;
  Vector x{{-0.379, -0.717}};
  for (int k = 0; k < 200 + periods; ++k) {
    if (k >= 200) motion.starts.push_back(x);
    carry(propagator, 0.0, motion.T, x, {.sensitivity = Sensitivity::none}, transition);
    x = transition.x1;
  }
  return motion;
}

void period(benchmark::State& state, const char* law, FlowKind kind) {
  const Motion motion = chaotic(law);
  FlowOptions options;
  options.kind = kind;
  Propagator propagator(motion.system, motion.p, {}, options), fast(motion.system, motion.p);
  Transition transition, reference;
  for (auto _ : state)
    for (const Vector& x : motion.starts) {
      carry(propagator, 0.0, motion.T, x, with_tangent, transition);
      benchmark::DoNotOptimize(transition.x1);
    }
  double difference = 0.0;
  for (const Vector& x : motion.starts) {
    carry(propagator, 0.0, motion.T, x, with_tangent, transition);
    carry(fast, 0.0, motion.T, x, with_tangent, reference);
    difference = std::max(difference, (transition.x1 - reference.x1).norm());
  }
  state.counters["difference"] = difference;
  state.counters["per_period"] =
      benchmark::Counter(periods, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.counters["periods_per_second"] = benchmark::Counter(periods, benchmark::Counter::kIsIterationInvariantRate);
}

void continuation(benchmark::State& state) {
  const HybridSystem system = make_oscillator("linear", "hertz");
  Vector p = default_parameters(system.parameters);
  p[oscillator_parameter::law + 1] = 0.1;  // b_H
  ContinuationOptions options;
  options.to = 0.90;
  options.switch_generations = 0;
  for (auto _ : state) {
    const PeriodicOrbit orbit = shoot(system, p, Vector{{2.0, 1.5}}, 1);
    benchmark::DoNotOptimize(continue_orbit(system, orbit, options));
  }
}

BENCHMARK_CAPTURE(period, hertz_fast, "hertz", FlowKind::automatic)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(period, hertz_general, "hertz", FlowKind::general)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(period, newton_fast, "newton", FlowKind::automatic)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(period, newton_general, "newton", FlowKind::general)->Unit(benchmark::kMicrosecond);
BENCHMARK(continuation)->Unit(benchmark::kMillisecond);

}  // namespace
