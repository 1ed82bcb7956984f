// SPDX-License-Identifier: GPL-3.0-or-later
// The measured problems: the systems of data/problems, states on their attractors, and starts near grazing. Also the solvers,
// graze and baselines, behind one interface: period(t0, t1, x, v) -> state with its 2x2 sensitivity and number of impacts.
#pragma once

#include "baselines/oscillator.hpp"

#include <graze/lib/models/oscillator.hpp>
#include <graze/lib/motion/lane_carrier.hpp>
#include <graze/lib/motion/transition.hpp>

#include <string>
#include <vector>

namespace benchmarks {

using baselines::Law;
using baselines::Parameters;
using baselines::Watch;

struct Problem {
  std::string name;
  Law law = Law::hertz;
  Parameters p = {};
  double x = 0.0, v = 0.0;  ///< a start in the basin of the attractor
  double period() const { return 2.0 * 3.14159265358979323846 / p.eta; }
};

/// The systems of data/problems, at parameters where their motion is chaotic (oscillators) or has several impacts (beams).
const std::vector<Problem>& problems();
const Problem& problem(const std::string& name);

graze::HybridSystem make_system(const Problem& problem);
graze::Vector make_parameters(const Problem& problem);

/// A run of at most one forcing period, and its result.
struct Start {
  double t0 = 0.0, t1 = 0.0, x = 0.0, v = 0.0;
};
struct Outcome {
  baselines::State<6> u = {};
  int impacts = 0;
  bool failed = true;
};

/// 200 forcing periods of the motion on the attractor.
const std::vector<Start>& attractor(const Problem& problem);
/// 200 runs whose first maximum lies within 1e-8 to 1e-3 of the barrier, beyond or short of it. They end half a forcing period
/// after it.
const std::vector<Start>& near_grazing(const Problem& problem);

/// graze through its public interface.
class Graze {
 public:
  Graze(const Problem& problem, double tolerance, graze::FlowKind kind = graze::FlowKind::automatic);
  Outcome period(const Start& start);
  graze::Propagator& propagator() { return propagator_; }

 private:
  graze::HybridSystem system_;
  graze::Propagator propagator_;
  graze::Transition transition_;
  graze::Vector x0_;
};

/// Many motions side by side, in the lanes of the processor's SIMD registers: only whole forcing periods from phase 0.
class GrazeLanes {
 public:
  GrazeLanes(const Problem& problem, double tolerance);
  Outcome period(const Start& start);
  /// All of `starts` over a forcing period; results are as in graze::LaneCarrier.
  const std::vector<graze::PeriodResult>& periods(const std::vector<Start>& starts);

 private:
  graze::HybridSystem system_;
  graze::LaneCarrier motions_;
  std::size_t parameters_;
  std::vector<graze::MotionStart> starts_;
  std::vector<graze::PeriodResult> results_;
};

/// The exact results: the general flow (GSL, events by bisection of cubic polynomials) at 1e-14, at its default step limit.
const std::vector<Outcome>& reference(const Problem& problem, const std::vector<Start>& starts);

/// The larger of the errors of the state, relative to 1 + |x|, and of the sensitivity, relative to its norm.
double error(const Outcome& outcome, const Outcome& exact);

/// Accuracy of a solver at a tolerance, over all starts. Runs with a wrong number of impacts are counted and have no error.
struct Accuracy {
  double tolerance = 0.0, median = 0.0, ninetieth = 0.0, worst = 0.0;
  int miscounted = 0;
};
template <class Solver> Accuracy accuracy(Solver&& solver, double tolerance, const Problem& p, const std::vector<Start>& starts);
Accuracy summarise(double tolerance, std::vector<double> errors, int miscounted);

template <class Solver> Accuracy accuracy(Solver&& solver, double tolerance, const Problem& p, const std::vector<Start>& starts) {
  const std::vector<Outcome>& exact = reference(p, starts);
  std::vector<double> errors;
  int miscounted = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const Outcome outcome = solver.period(starts[i]);
    if (exact[i].failed) continue;
    if (outcome.failed || outcome.impacts != exact[i].impacts)
      ++miscounted;
    else
      errors.push_back(error(outcome, exact[i]));
  }
  return summarise(tolerance, std::move(errors), miscounted);
}

/// The loosest tolerance, in steps of a quarter of a decade, at which 90 per cent of the periods on the attractor end within
/// 1e-10 of the exact result (state and sensitivity). Chaos amplifies errors: the worst ones are a property of the motion, and
/// the same for all solvers.
inline constexpr double wanted_accuracy = 1e-10;
template <class AccuracyAt> Accuracy tuned(const AccuracyAt& accuracy_at) {
  const auto at = [&](int quarters) { return accuracy_at(std::pow(10.0, -0.25 * quarters)); };
  const auto good = [](const Accuracy& a) { return a.ninetieth <= wanted_accuracy && a.miscounted <= 20; };
  int quarters = 32;  // 1e-8
  Accuracy best = at(quarters);
  while (!good(best) && quarters < 56) best = at(quarters += 2);
  if (quarters == 32) return best;
  const Accuracy looser = at(quarters - 1);
  return good(looser) ? looser : best;
}

/// A baseline as a solver. `stepper()` is the baseline itself.
template <template <Law, std::size_t> class Baseline, Law law> class Solver {
 public:
  Solver(const Problem& problem, double tolerance, Watch watch) : p_(problem.p), baseline_(problem.p, tolerance, watch) {}
  Outcome period(const Start& start) {
    Outcome out;
    out.u = baselines::start<6>(start.x, start.v);
    const baselines::Run run = baselines::run<law, 6>(baseline_, p_, start.t0, start.t1, out.u);
    out.impacts = run.impacts;
    out.failed = run.failed;
    return out;
  }
  Baseline<law, 6>& stepper() { return baseline_; }

 private:
  Parameters p_;
  Baseline<law, 6> baseline_;
};

}  // namespace benchmarks
