// SPDX-License-Identifier: GPL-3.0-or-later
#include "problems.hpp"

#include <map>
#include <random>
#include <stdexcept>

namespace benchmarks {

using namespace graze;

const std::vector<Problem>& problems() {
  const auto beam = [](const char* name, Law law, double eta) {
    return Problem{name, law, {.b = 0.026, .beta = 36.0 / 35.0, .xi = 0.08, .eta = eta, .r = 0.079, .k_H = 100.0}, 0.0, 0.0};
  };
  static const std::vector<Problem> all = {{"hertz-damped", Law::hertz, {.eta = 0.711, .b_H = 0.1}, -0.379, -0.717},
                                           {"hertz-undamped", Law::hertz, {.eta = 0.711}, -0.379, -0.717},
                                           {"newton-elastic", Law::newton, {.eta = 0.711}, -0.379, -0.717},
                                           beam("beam-hertz", Law::hertz, 0.554),
                                           beam("beam-newton", Law::newton, 0.554)};
  return all;
}

const Problem& problem(const std::string& name) {
  for (const Problem& p : problems())
    if (p.name == name) return p;
  throw std::invalid_argument("no problem is named " + name);
}

HybridSystem make_system(const Problem& problem) {
  return make_oscillator(problem.p.beta == 0.0 ? "linear" : "cantilever", problem.law == Law::hertz ? "hertz" : "newton");
}

Vector make_parameters(const Problem& problem) {
  const Parameters& q = problem.p;
  if (problem.law == Law::hertz) return Vector{{q.b, q.beta, q.xi, q.eta, q.r, q.k_H, q.b_H}};
  return Vector{{q.b, q.beta, q.xi, q.eta, q.r, q.k_r}};
}

Graze::Graze(const Problem& problem, double tolerance, FlowKind kind)
    : system_(make_system(problem)), propagator_(system_, make_parameters(problem), {}, {.kind = kind, .tolerance = tolerance}),
      x0_(2) {}

Outcome Graze::period(const Start& start) {
  x0_ << start.x, start.v;
  carry(propagator_, start.t0, start.t1, x0_, {.sensitivity = Sensitivity::state}, transition_);
  Outcome out;
  out.failed = transition_.termination != Termination::time;
  if (out.failed) return out;
  out.u = {transition_.x1[0],     transition_.x1[1],     transition_.Phi(0, 0),
           transition_.Phi(1, 0), transition_.Phi(0, 1), transition_.Phi(1, 1)};
  for (const std::size_t event : transition_.event_sequence) out.impacts += begins_contact(system_.events[event].kind) ? 1 : 0;
  return out;
}

GrazeLanes::GrazeLanes(const Problem& problem, double tolerance)
    : system_(make_system(problem)), motions_(system_, {.tolerance = tolerance}),
      parameters_(motions_.add_parameters(make_parameters(problem))) {}

const std::vector<PeriodResult>& GrazeLanes::periods(const std::vector<Start>& starts) {
  starts_.clear();
  for (const Start& start : starts) starts_.push_back({parameters_, start.x, start.v});
  motions_.carry(starts_, 1, true, results_);
  return results_;
}

Outcome GrazeLanes::period(const Start& start) {
  const PeriodResult& out = periods({start}).front();
  return {{out.x, out.v, out.Phi[0], out.Phi[2], out.Phi[1], out.Phi[3]}, out.impacts, out.termination != Termination::time};
}

const std::vector<Start>& attractor(const Problem& problem) {
  static std::map<std::string, std::vector<Start>> known;
  std::vector<Start>& starts = known[problem.name];
  if (!starts.empty()) return starts;
  Graze solver(problem, 1e-13);
  Start start{0.0, problem.period(), problem.x, problem.v};
  for (int k = 0; k < 500; ++k) {
    if (k >= 300) starts.push_back(start);
    const Outcome out = solver.period(start);
    start.x = out.u[0];
    start.v = out.u[1];
  }
  return starts;
}

const std::vector<Start>& near_grazing(const Problem& problem) {
  static std::map<std::string, std::vector<Start>> known;
  std::vector<Start>& starts = known[problem.name];
  std::mt19937 engine(48);
  const auto random = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(engine); };
  const Parameters& p = problem.p;
  const baselines::Field<Law::newton, 2> field{p};
  const double size = p.r;
  while (starts.size() < 200) {
    const double side = random(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    const double t_m = random(1.0, 2.0) * problem.period(), x_m = p.r + side * 0.5 * size * std::pow(10.0, random(-8.0, -3.0));
    baselines::State<2> u{x_m, 0.0}, k1, k2, k3, k4, w;
    field(t_m, u.data(), k1.data());
    if (k1[1] > -0.05 * size) continue;
    // Backwards from the maximum by small steps of RK4: its error moves the maximum by far less than its distance from the
    // barrier.
    const int steps = 2000;
    const double h = -random(0.2, 0.9) * problem.period() / steps;
    const auto shift = [&](const baselines::State<2>& k, double s) {
      return baselines::State<2>{u[0] + s * k[0], u[1] + s * k[1]};
    };
    double t = t_m;
    bool clear = true;
    for (int i = 0; i < steps && clear; ++i, t += h) {
      field(t, u.data(), k1.data());
      field(t + h / 2, (w = shift(k1, h / 2)).data(), k2.data());
      field(t + h / 2, (w = shift(k2, h / 2)).data(), k3.data());
      field(t + h, (w = shift(k3, h)).data(), k4.data());
      for (std::size_t q = 0; q < 2; ++q) u[q] += h / 6 * (k1[q] + 2 * k2[q] + 2 * k3[q] + k4[q]);
      clear = std::abs(u[0]) < 50.0 * size && (u[1] > 0.0 && u[0] < p.r + size * 1e-3 ? true : u[0] < p.r - 0.01 * size);
    }
    if (clear && u[0] < p.r - 0.01 * size) starts.push_back({t, t_m + 0.5 * problem.period(), u[0], u[1]});
  }
  return starts;
}

const std::vector<Outcome>& reference(const Problem& problem, const std::vector<Start>& starts) {
  static std::map<const Start*, std::vector<Outcome>> known;
  std::vector<Outcome>& outcomes = known[starts.data()];
  if (!outcomes.empty()) return outcomes;
  Graze solver(problem, 1e-14, FlowKind::general);
  for (const Start& start : starts) outcomes.push_back(solver.period(start));
  return outcomes;
}

double error(const Outcome& a, const Outcome& b) {
  const double state =
      std::max(std::abs(a.u[0] - b.u[0]), std::abs(a.u[1] - b.u[1])) / (1.0 + std::max(std::abs(b.u[0]), std::abs(b.u[1])));
  double difference = 0.0, size = 1.0;
  for (std::size_t q = 2; q < 6; ++q) {
    difference = std::max(difference, std::abs(a.u[q] - b.u[q]));
    size = std::max(size, std::abs(b.u[q]));
  }
  return std::max(state, difference / size);
}

Accuracy summarise(double tolerance, std::vector<double> errors, int miscounted) {
  Accuracy out{tolerance, 0.0, 0.0, 0.0, miscounted};
  if (errors.empty()) {
    out.median = out.ninetieth = out.worst = 1.0;
    return out;
  }
  std::sort(errors.begin(), errors.end());
  out.median = errors[errors.size() / 2];
  out.ninetieth = errors[errors.size() * 9 / 10];
  out.worst = errors.back();
  return out;
}

}  // namespace benchmarks
