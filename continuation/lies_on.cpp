// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch_graph.hpp>

#include <algorithm>

namespace graze {

bool lies_on(const HybridSystem& system, const Branch& branch, const PeriodicOrbit& orbit, double value) {
  if (branch.period != orbit.period) return false;
  const std::size_t n = orbit.states.size();
  Vector p = branch.parameters;
  p[static_cast<Eigen::Index>(parameter_index(system.parameters, branch.parameter))] = value;
  for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) {
    const BranchPoint &a = branch.points[i], &b = branch.points[i + 1];
    if (a.states.size() != n || b.states.size() != n || (a.value < value) == (b.value < value)) continue;
    const double s = (value - a.value) / (b.value - a.value);
    std::vector<Vector> between(n);
    double step = 0.0;
    for (std::size_t k = 0; k < n; ++k) {
      between[k] = a.states[k] + s * (b.states[k] - a.states[k]);
      step = std::max(step, (b.states[k] - a.states[k]).lpNorm<Eigen::Infinity>());
    }
    for (std::size_t shift = 0; shift < n; ++shift) {
      double distance = 0.0;
      for (std::size_t k = 0; k < n; ++k)
        distance = std::max(distance, (between[(k + shift) % n] - orbit.states[k]).lpNorm<Eigen::Infinity>());
      // Between two points the curve stays closer to its chord than half its length; Newton then decides.
      if (distance > 0.5 * step + 1e-6) continue;
      ShootingOptions options;
      options.reduce_period = false;
      // A state on the chord may lie just inside a hard barrier.
      const bool allowed = std::all_of(between.begin(), between.end(), [&](const Vector& x) {
        return !system.initial_mode || system.initial_mode(0.0, x, p).has_value();
      });
      const PeriodicOrbit there = shoot(system, p, allowed ? between : std::vector<Vector>{a.state()}, orbit.period, options);
      // Next to a hard grazing Newton may end on the family with one impact more or less.
      const bool same_family = there.impacts == a.impacts || there.impacts == b.impacts;
      if (there.converged() && same_family && same_orbit(there, orbit, 1e-6)) return true;
    }
  }
  return false;
}

}  // namespace graze
