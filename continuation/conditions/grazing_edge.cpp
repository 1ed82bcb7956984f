// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/conditions/grazing_edge.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

bool same_edge(const GrazingEdge& a, const GrazingEdge& b, double unit) {
  if (a.states.empty()) return false;  // the touching orbit could not be carried around
  const auto near = [](const Vector& x, const Vector& y) {
    return (x - y).lpNorm<Eigen::Infinity>() < 1e-9 * (1.0 + x.lpNorm<Eigen::Infinity>());
  };
  return a.period == b.period && a.impacts == b.impacts && std::abs(a.value - b.value) < 1e-9 * (unit + std::abs(a.value)) &&
         std::any_of(b.states.begin(), b.states.end(), [&](const Vector& x) { return near(x, a.states.front()); });
}

int to_least_period(PeriodicOrbit& orbit, LocatedGrazing& grazing) {
  const auto nodes = static_cast<Eigen::Index>(orbit.nodes.size()), n = orbit.state.size();
  for (int period = 1; period <= orbit.period / 2; ++period) {
    const Eigen::Index shift = nodes * period / orbit.period * n;
    if (orbit.period % period != 0 || nodes * period % orbit.period != 0) continue;
    const Vector u = grazing.u.head(nodes * n);
    if ((u.tail(nodes * n - shift) - u.head(nodes * n - shift)).lpNorm<Eigen::Infinity>() > 1e-10) continue;
    // Behind the nodes stand the duration of an autonomous orbit, and the parameter's value.
    const double part = static_cast<double>(period) / orbit.period;
    const auto shorten = [&](Vector& v) {
      const Eigen::Index others = v.size() - nodes * n;
      Vector kept(shift + others);
      kept << v.head(shift), v.tail(others);
      if (orbit.multipliers.section == Section::autonomous) kept[shift] *= part;
      v = kept;
    };
    shorten(grazing.u);
    shorten(grazing.family_dp);
    orbit.period = period;
    orbit.duration *= part;
    orbit.nodes.resize(static_cast<std::size_t>(shift / n));
    // There are no states if the orbit could not be carried through its grazing.
    if (!orbit.states.empty()) orbit.states.resize(static_cast<std::size_t>(period));
    return period;
  }
  return orbit.period;
}

GrazingEdge edge_at(const SpecialPoint& point, const PeriodicOrbit& orbit, int impacts) {
  return {point.value, orbit.period, impacts, orbit.states};
}

GrazingEdge partner_edge(const SpecialPoint& point, LocatedGrazing& grazing, bool lost, PeriodicOrbit* orbit) {
  PeriodicOrbit at_grazing = point.orbit;
  int impacts = grazing.orbit.impacts + (lost ? 0 : 1);
  if (lost) impacts = impacts * to_least_period(at_grazing, grazing) / point.orbit.period;
  GrazingEdge edge = edge_at(point, at_grazing, impacts);
  if (orbit) *orbit = std::move(at_grazing);
  return edge;
}

GrazingEdge touching_edge(const SpecialPoint& point, LocatedGrazing& grazing, bool lost, PeriodicOrbit* orbit) {
  if (lost) return partner_edge(point, grazing, lost, orbit);
  if (orbit) *orbit = point.orbit;
  return edge_at(point, point.orbit, grazing.orbit.impacts);
}

std::vector<TurnPattern> patterns_up_to(int turns, bool lost) {
  std::vector<TurnPattern> list;
  for (int m = lost ? 1 : 2; m <= turns; ++m) {
    list.push_back({m, 1});
    if (m > 2) list.push_back({m, m - 1});
  }
  return list;
}

GrazingEdge pattern_edge(const GrazingEdge& touching, TurnPattern pattern) {
  GrazingEdge edge = touching;
  edge.period *= pattern.turns;
  edge.impacts = pattern.turns * touching.impacts + pattern.struck;
  return edge;
}

}  // namespace graze
