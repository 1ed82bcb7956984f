// SPDX-License-Identifier: GPL-3.0-or-later
// Cost of an orbit as a function of its period n, of a point of a branch, and of a row of a sweep. graze uses `shoot`,
// `continue_orbit` and `sweep` at their defaults (1e-13). Their additional work is included: free re-simulation and checks;
// test functions and the located period doubling; the search for a periodic attractor. The baselines do the minimum for the
// numbers, at the tolerance that gives them 1e-10 over a period. They use Newton's method on the return map, the same at as
// many parameter values as the branch has points, and a transient with Gram-Schmidt.
#include "solvers.hpp"

#include <graze/continuation/graph/continuation.hpp>
#include <graze/floquet/follow/sweep.hpp>

namespace benchmarks {
namespace {

using namespace graze;

struct Known {
  int n;
  double eta, x, v;
};
/// Orbits of the undamped Hertz oscillator, data/reference.toml.
constexpr Known orbits[] = {{1, 0.94, 2.0403618495903122, 1.4731190769020732},
                            {2, 0.746, 1.7281647066530512, -1.3466409698271533},
                            {4, 0.744, 1.8776844598713907, -1.0403064428256055},
                            {16, 0.738, 1.9799649748980708, -0.75703864359156714},
                            {24, 0.7116, 2.061810096981707, -0.027576058604957682}};
constexpr double off = 1e-6;  // distance of the guess from the orbit

Problem at(const Problem& p, double eta) {
  Problem out = p;
  out.p.eta = eta;
  return out;
}

/// Newton's method on the return map of n periods. The Phi of the last iteration is the monodromy matrix.
template <class Solver> bool return_map_newton(Solver& solver, const Problem& p, int n, double& x, double& v) {
  for (int i = 0; i < 20; ++i) {
    const Outcome out = solver.period({0.0, n * p.period(), x, v});
    if (out.failed) return false;
    const double F = out.u[0] - x, G = out.u[1] - v;
    const double a = out.u[2] - 1.0, c = out.u[3], b = out.u[4], d = out.u[5] - 1.0, D = a * d - b * c;
    const double dx = (b * G - d * F) / D, dv = (c * F - a * G) / D;
    if (std::hypot(F, G) < wanted_accuracy * (1.0 + std::hypot(x, v))) return true;
    x += dx;
    v += dv;
  }
  return false;
}

void orbit_of_graze(benchmark::State& state, const Problem& p, const Known& known) {
  const HybridSystem system = make_system(p);
  const Vector parameters = make_parameters(p), exact{{known.x, known.v}}, guess = exact + Vector::Constant(2, off);
  PeriodicOrbit orbit;
  for (auto _ : state) {
    orbit = shoot(system, parameters, guess, known.n);
    benchmark::DoNotOptimize(orbit.state);
  }
  if (!orbit.converged()) return state.SkipWithError("not converged");
  per_item(state, 1);
  state.counters["error"] = (orbit.state - exact).norm();
}

template <class Make>
void orbit_of_baseline(benchmark::State& state, const Problem& p, const Known& known, const Make& make, double tolerance) {
  double x = 0.0, v = 0.0;
  for (auto _ : state) {
    auto solver = make(tolerance);
    x = known.x + off;
    v = known.v + off;
    if (!return_map_newton(solver, p, known.n, x, v)) return state.SkipWithError("not converged");
    benchmark::DoNotOptimize(x);
  }
  per_item(state, 1);
  state.counters["error"] = std::hypot(x - known.x, v - known.v);
}

Branch branch() {
  const Problem p = at(problem("hertz-damped"), 0.95);
  const HybridSystem system = make_system(p);
  ContinuationOptions options;
  options.to = 0.90;
  options.switch_generations = 0;
  const PeriodicOrbit orbit = shoot(system, make_parameters(p), Vector{{2.0, 1.5}}, 1);
  return continue_orbit(system, orbit, options).front();
}

void point_of_graze(benchmark::State& state) {
  Branch known;
  for (auto _ : state) {
    known = branch();
    benchmark::DoNotOptimize(known);
  }
  per_item(state, known.points.size());
  state.counters["points"] = static_cast<double>(known.points.size());
}

/// Natural continuation with secant predictions.
template <class MakeAt> void point_of_baseline(benchmark::State& state, const MakeAt& make_at, double tolerance) {
  static const std::size_t points = branch().points.size();
  for (auto _ : state) {
    double x = 2.0, v = 1.5, x_before = x, v_before = v;
    for (std::size_t i = 0; i < points; ++i) {
      const Problem p = at(problem("hertz-damped"), 0.95 - 0.05 * static_cast<double>(i) / static_cast<double>(points - 1));
      auto solver = make_at(p)(tolerance);
      double x_now = i > 1 ? 2.0 * x - x_before : x, v_now = i > 1 ? 2.0 * v - v_before : v;
      if (!return_map_newton(solver, p, 1, x_now, v_now)) return state.SkipWithError("not converged");
      x_before = std::exchange(x, x_now);
      v_before = std::exchange(v, v_now);
    }
    benchmark::DoNotOptimize(x);
  }
  per_item(state, points);
  state.counters["points"] = static_cast<double>(points);
}

constexpr int transient = 1000, averaged = 2000;

void row_of_graze(benchmark::State& state, const Problem& p) {
  const HybridSystem system = make_system(p);
  SweepOptions options;
  options.from = p.p.eta;
  options.to = p.p.eta + 1e-6;
  options.step = 1e-3;
  options.first_transient = transient;
  options.attractor.transient = transient;
  options.attractor.lyapunov.standard_error = 0.0;
  options.attractor.lyapunov.max_periods = averaged;
  std::vector<SweepRow> rows;
  for (auto _ : state) rows = sweep(system, make_parameters(p), Vector{{p.x, p.v}}, options);
  if (rows.size() != 1 || rows.front().attractor.time_average.periods != averaged)
    return state.SkipWithError("not the row meant");
  per_item(state, 1);
  state.counters["lambda"] = rows.front().attractor.exponents.front();
}

template <template <Law, std::size_t> class Baseline, Law law>
void row_of_baseline(benchmark::State& state, const Problem& p, double tolerance) {
  double lambda = 0.0;
  for (auto _ : state) {
    Baseline<law, 2> motion(p.p, tolerance, Watch::located);
    baselines::State<2> z{p.x, p.v};
    for (int k = 0; k < transient; ++k)
      if (baselines::run<law, 2>(motion, p.p, 0.0, p.period(), z).failed) return state.SkipWithError("failed");
    Solver<Baseline, law> solver(p, tolerance, Watch::located);
    baselines::State<6> u{z[0], z[1], 1.0, 0.0, 0.0, 1.0};
    double first = 0.0, second = 0.0;
    for (int k = 0; k < averaged; ++k) {
      if (baselines::run<law, 6>(solver.stepper(), p.p, 0.0, p.period(), u).failed) return state.SkipWithError("failed");
      const double size = std::hypot(u[2], u[3]);
      first += std::log(size);
      u[2] /= size;
      u[3] /= size;
      const double along = u[2] * u[4] + u[3] * u[5];
      u[4] -= along * u[2];
      u[5] -= along * u[3];
      const double across = std::hypot(u[4], u[5]);
      second += std::log(across);
      u[4] /= across;
      u[5] /= across;
    }
    benchmark::DoNotOptimize(second);
    lambda = first / (averaged * p.period());
  }
  per_item(state, 1);
  state.counters["lambda"] = lambda;
}

template <template <Law, std::size_t> class Baseline> void register_baseline(const std::string& name) {
  const auto make_at = [](const Problem& p) {
    return [p](double tolerance) { return Solver<Baseline, Law::hertz>(p, tolerance, Watch::located); };
  };
  // Tuned where the motion is chaotic, on the system with contact damping or without.
  const auto tolerance = [name, make_at](const char* system) {
    return tuning(problem(system), name, make_at(problem(system))).tolerance;
  };
  for (const Known& known : orbits) {
    const Problem p = at(problem("hertz-undamped"), known.eta);
    benchmark::RegisterBenchmark(("orbit/n=" + std::to_string(known.n) + "/" + name).c_str(), [=](benchmark::State& state) {
      orbit_of_baseline(state, p, known, make_at(p), tolerance("hertz-undamped"));
    });
  }
  benchmark::RegisterBenchmark(("branch-point/hertz-damped/" + name).c_str(),
                               [=](benchmark::State& state) { point_of_baseline(state, make_at, tolerance("hertz-damped")); });
  benchmark::RegisterBenchmark(("sweep-row/hertz-damped/" + name).c_str(), [=](benchmark::State& state) {
    row_of_baseline<Baseline, Law::hertz>(state, problem("hertz-damped"), tolerance("hertz-damped"));
  });
}

const bool registered = [] {
  for (const Known& known : orbits)
    benchmark::RegisterBenchmark(("orbit/n=" + std::to_string(known.n) + "/graze").c_str(), [known](benchmark::State& state) {
      orbit_of_graze(state, at(problem("hertz-undamped"), known.eta), known);
    });
  benchmark::RegisterBenchmark("branch-point/hertz-damped/graze", point_of_graze);
  benchmark::RegisterBenchmark("sweep-row/hertz-damped/graze",
                               [](benchmark::State& state) { row_of_graze(state, problem("hertz-damped")); });
  register_baseline<baselines::GslRk8pd>("gsl-rk8pd");
  register_baseline<baselines::BoostDopri5>("boost-dopri5");
  return true;
}();

}  // namespace
}  // namespace benchmarks
