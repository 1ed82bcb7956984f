// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/graph/nearest_special_points.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

bool is_bifurcation(PointType type) { return type != PointType::EP && type != PointType::UZ && type != PointType::MX; }

double first_exponent(const FloquetMultipliers& multipliers) { return multipliers.exponents.front(); }

/// The parameter value between two neighbouring stable points of a branch at which the first exponent is `wanted`, by
/// bisection; empty if an orbit between them does not converge.
std::optional<double> between(const HybridSystem& system, const Branch& branch, const BranchPoint& a, const BranchPoint& b,
                              std::size_t parameter, double wanted) {
  double low = a.value, high = b.value;
  const double sign = first_exponent(a.multipliers) < wanted ? 1.0 : -1.0;
  for (int halving = 0; halving < 44; ++halving) {
    const double value = 0.5 * (low + high), share = (value - a.value) / (b.value - a.value);
    Vector p = branch.parameters;
    p[static_cast<Eigen::Index>(parameter)] = value;
    std::vector<Vector> guess;
    for (std::size_t k = 0; k < a.states.size(); ++k) guess.push_back((1.0 - share) * a.states[k] + share * b.states[k]);
    const PeriodicOrbit orbit = shoot(system, p, guess, branch.period);
    if (!orbit.converged() || orbit.period != branch.period) return std::nullopt;
    (sign * (first_exponent(orbit.multipliers) - wanted) < 0.0 ? low : high) = value;
  }
  return 0.5 * (low + high);
}

}  // namespace

const SpecialPoint* NearestSpecialPoints::nearest(double value) const {
  if (!below || !above) return below ? &*below : above ? &*above : nullptr;
  return value - below->value < above->value - value ? &*below : &*above;
}

NearestSpecialPoints nearest_special_points(const HybridSystem& system, const PeriodicOrbit& orbit,
                                            const NeighbourhoodOptions& options) {
  const std::size_t parameter = parameter_index(system.parameters, options.parameter);
  const double here = orbit.parameters[static_cast<Eigen::Index>(parameter)];
  ContinuationOptions following;
  following.parameter = options.parameter;
  following.from = here - options.reach;
  following.to = here + options.reach;
  following.both_directions = true;
  following.switch_generations = 0;
  following.cancelled = options.cancelled;
  NearestSpecialPoints out;
  for (const Branch& branch : continue_orbit(system, orbit, following)) {
    if (is_forced(system) && branch.period != orbit.period) continue;
    for (const SpecialPoint& point : branch.special_points) {
      if (!is_bifurcation(point.type)) continue;
      std::optional<SpecialPoint>& side = point.value < here ? out.below : out.above;
      if (!side || std::abs(point.value - here) < std::abs(side->value - here)) side = point;
    }
    for (std::size_t k = 0; options.exponent && k + 1 < branch.points.size(); ++k) {
      const BranchPoint &a = branch.points[k], &b = branch.points[k + 1];
      if (!a.stable || !b.stable || a.impacts != b.impacts || a.value == b.value) continue;
      const double at_a = first_exponent(a.multipliers) - *options.exponent,
                   at_b = first_exponent(b.multipliers) - *options.exponent;
      if (!(at_a * at_b < 0.0)) continue;
      const auto value = between(system, branch, a, b, parameter, *options.exponent);
      if (value && (!out.value_of_exponent || std::abs(*value - here) < std::abs(*out.value_of_exponent - here)))
        out.value_of_exponent = value;
    }
  }
  return out;
}

}  // namespace graze
