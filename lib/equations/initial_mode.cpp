// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/equations/initial_mode.hpp>
#include <graze/lib/system/guard_rounding.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace graze::equations {

InitialMode mode_by_guards(const HybridSystem& system, const std::vector<std::vector<ToleratedConstraint>>& constraints,
                           const std::vector<std::vector<ScalarFunction>>& conditions) {
  std::vector<VectorFunction> fields;
  std::vector<std::vector<Guard>> guards(system.modes.size());
  for (const Mode& mode : system.modes) fields.push_back(mode.field);
  for (const Event& event : system.events) guards[event.from].push_back(event.guard);
  // Modes with constraints are tested before those without: on a constraint, rounding would decide between the latter.
  std::vector<std::size_t> order(system.modes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return constraints[a].size() > constraints[b].size(); });
  HybridSystem forcing;
  forcing.forcing_frequency = system.forcing_frequency;
  forcing.period = system.period;
  return [fields, guards, constraints, conditions, order, forcing](double t, const Vector& x,
                                                                   const Vector& p) -> std::optional<std::size_t> {
    Vector f(x.size()), later(x.size());
    const double size = 1.0 + x.lpNorm<Eigen::Infinity>();
    const auto keeps_constraints = [&](std::size_t mode) {
      return std::all_of(constraints[mode].begin(), constraints[mode].end(),
                         [&](const ToleratedConstraint& one) { return std::abs(one.value(t, x, p)) <= one.tolerance * size; });
    };
    const auto keeps_conditions = [&](std::size_t mode) {
      return std::all_of(conditions[mode].begin(), conditions[mode].end(),
                         [&](const ScalarFunction& one) { return one(t, x, p) >= -guard_tolerance * size; });
    };
    const auto motion_stays_in = [&](std::size_t mode) {
      const auto field = [&](double time, const Vector& at, Vector& out) { fields[mode](time, at, p, out); };
      return keeps_constraints(mode) && keeps_conditions(mode) &&
             std::all_of(guards[mode].begin(), guards[mode].end(), [&](const Guard& guard) {
               const double h = guard.value(t, x, p);
               if (h != 0.0) return h < 0.0;
               field(t, x, f);
               const double speed = transversality(guard, t, x, f, p);
               if (!rests(speed, guard_scale(guard, t, x, p), f)) return speed < 0.0;
               return rate_after(rest_glance * time_unit(forcing, p), guard, field, t, x, p, f, later) <= 0.0;
             });
    };
    const auto admits = [&](std::size_t mode) {
      return keeps_constraints(mode) && keeps_conditions(mode) &&
             std::all_of(guards[mode].begin(), guards[mode].end(), [&](const Guard& guard) {
               const double h = guard.value(t, x, p);
               return h <= 0.0 || h <= guard_width(guard_scale(guard, t, x, p), t, x);
             });
    };
    for (const std::size_t mode : order)
      if (motion_stays_in(mode)) return mode;
    for (const std::size_t mode : order)
      if (admits(mode)) return mode;
    return std::nullopt;
  };
}

}  // namespace graze::equations
