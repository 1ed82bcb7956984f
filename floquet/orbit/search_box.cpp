// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/search_box.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// Steps that a stretch is always allowed, and steps allowed per evaluation in the longest stretch of the motions (a step of a
/// series of order 16 counts as 16 evaluations: this is 32 times their steps).
constexpr std::size_t least_steps = 2000, steps_of_evaluations = 2;
/// Consecutive failures in the first period after which no other motion is tried: each may use the maximum number of steps.
constexpr int most_failures = 3;

}  // namespace

SearchBox search_box(const HybridSystem& system, const Vector& p, const FlowOptions& options, int periods) {
  const auto n = static_cast<Eigen::Index>(system.states);
  const double T = forcing_period(system, p);
  Propagator propagator(system, p, {}, options);
  double size = 0.0;
  int failures = 0;
  bool carried = false;
  SearchBox box;
  Transition transition;
  const auto run_from = [&](Vector x, int counted_from) {
    for (int k = 0; k < periods; ++k) {
      carry(propagator, 0.0, T, x, {.sensitivity = Sensitivity::none}, transition);
      if (transition.termination != Termination::time) {
        // Beyond a barrier, and besides motions that escape, other motions may be bounded.
        const bool others =
            transition.termination == Termination::inadmissible_start || transition.termination == Termination::escape;
        if (!carried && !others) {
          ++failures;
          box.ended = transition.termination;
        }
        break;
      }
      carried = true;
      const bool settled = (transition.x1 - x).norm() <= 1e-9 * x.norm();
      x = transition.x1;
      if (k >= counted_from || settled) size = std::max(size, x.cwiseAbs().maxCoeff());
      if (settled) break;
    }
  };
  for (const double start : {0.0, 0.1, -0.1}) run_from(Vector::Constant(n, start), 0);
  // A hard barrier at r < 0 leaves no room near the origin.
  for (double start = 0.2; size == 0.0 && start < 1e4 && failures < most_failures; start *= 2.0) {
    run_from(Vector::Constant(n, -start), 0);
    run_from(Vector::Constant(n, start), 0);
  }
  // Motions from rest may never meet a barrier that others hit. The box reaches to the barrier, and covers the long-term states
  // of motions that start far enough from it to hit it.
  for (const Event& event : system.events) {
    if (!event.guard.level || event.from != 0) continue;
    const LevelGuard& guard = *event.guard.level;
    const double level = p[static_cast<Eigen::Index>(guard.level)], at_rest = std::max(size, std::abs(level));
    for (const double times : {1.0, 2.0, 4.0}) {
      if (failures >= most_failures && !carried) break;
      Vector start = Vector::Zero(n);
      start[static_cast<Eigen::Index>(guard.coordinate)] = level - guard.sign * times * at_rest;
      run_from(start, periods / 2);
    }
    size = std::max(size, std::abs(level));
  }
  // Stroboscopic states show only one phase; a motion passes through all others, so every coordinate gets the largest size.
  const double reach = 1.5 * size + 1e-3;
  box.lower = Vector::Constant(n, -reach);
  box.upper = Vector::Constant(n, reach);
  if (carried) box.ended = Termination::time;
  box.max_steps = std::min(options.max_steps, std::max(least_steps, steps_of_evaluations * propagator.most_evaluations()));
  return box;
}

}  // namespace graze
