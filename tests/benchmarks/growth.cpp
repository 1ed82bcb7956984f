// SPDX-License-Identifier: GPL-3.0-or-later
// How does the cost of a forcing period, with its sensitivity, grow with the number of impacts in it, and with the number of
// states? (With the period n of an orbit: orbits.cpp.)
#include "solvers.hpp"
#include "support/rigid_stop.hpp"

namespace benchmarks {
namespace {

using namespace graze;

/// The elastic stop at x = 0: half of the forcing period the force presses the mass against it, and it bounces; the slower the
/// forcing, the more often.
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

/// A chain of m equal masses, each on its own spring and tied to the next, the first one forced and before a rigid stop:
///     x_i'' + 2 b x_i' + x_i + kappa sum over its neighbours (x_i - x_j) = [i = 1] xi cos(eta t),   x_1 <= r.
HybridSystem chain(Eigen::Index masses) {
  enum : Eigen::Index { b, kappa, xi, eta, r, k_r };
  using support::detail::parameter;
  HybridSystem system;
  system.name = "chain";
  system.states = static_cast<std::size_t>(2 * masses);
  system.parameters = {parameter("b", 0.05, 0.0),          parameter("kappa", 0.5, 0.0), parameter("xi", 1.0),
                       parameter("eta", 0.711, 0.0, true), parameter("r", 1.0),          parameter("k_r", 0.8, 0.0, false, 1.0)};
  system.forcing_frequency = eta;
  Mode mode;
  mode.name = "free";
  mode.field = [masses](double t, const Vector& x, const Vector& p, Vector& f) {
    for (Eigen::Index i = 0; i < masses; ++i) {
      const double here = x[2 * i];
      double a = -2.0 * p[b] * x[2 * i + 1] - here;
      if (i > 0) a -= p[kappa] * (here - x[2 * i - 2]);
      if (i + 1 < masses) a -= p[kappa] * (here - x[2 * i + 2]);
      f[2 * i] = x[2 * i + 1];
      f[2 * i + 1] = a;
    }
    f[1] += p[xi] * std::cos(p[eta] * t);
  };
  mode.field_dx = [masses](double, const Vector&, const Vector& p, Matrix& J) {
    J.setZero();
    for (Eigen::Index i = 0; i < masses; ++i) {
      J(2 * i, 2 * i + 1) = 1.0;
      J(2 * i + 1, 2 * i + 1) = -2.0 * p[b];
      J(2 * i + 1, 2 * i) = -1.0;
      for (const Eigen::Index j : {i - 1, i + 1})
        if (j >= 0 && j < masses) {
          J(2 * i + 1, 2 * i) -= p[kappa];
          J(2 * i + 1, 2 * j) = p[kappa];
        }
    }
  };
  mode.field_dp = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };  // not asked for here
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f.setZero();
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
  };
  system.modes = {mode};
  system.events = {support::detail::rigid_stop("impact", 0, r, k_r, 1.0)};
  return system;
}

void states(benchmark::State& state, Eigen::Index masses) {
  const HybridSystem system = chain(masses);
  const Vector p = default_parameters(system.parameters);
  const double T = forcing_period(system, p);
  Propagator propagator(system, p);
  Transition transition;
  Vector x = Vector::Zero(2 * masses);
  const auto period = [&] { carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::state}, transition); };
  for (int k = 0; k < 20; ++k, x = transition.x1) period();
  for (auto _ : state) {
    period();
    benchmark::DoNotOptimize(transition.x1);
  }
  if (transition.termination != Termination::time) return state.SkipWithError("failed");
  per_item(state, 1);
  state.counters["impacts"] = static_cast<double>(transition.event_sequence.size());
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
  for (const Eigen::Index masses : {1, 2, 4, 8})
    benchmark::RegisterBenchmark(("states/n=" + std::to_string(2 * masses) + "/graze").c_str(),
                                 [masses](benchmark::State& state) { states(state, masses); });
  return true;
}();

}  // namespace
}  // namespace benchmarks
