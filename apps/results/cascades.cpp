// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/cascades.hpp>
#include <graze/apps/text/number.hpp>
#include <graze/apps/text/table.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

/// A period doubling and the branch on which it lies.
struct Place {
  const Branch* branch = nullptr;
  const SpecialPoint* point = nullptr;
  bool operator==(const Place& other) const { return point == other.point; }
};

std::vector<Place> doublings(const Branch& branch) {
  std::vector<Place> list;
  for (const SpecialPoint& point : branch.special_points)
    if (point.type == PointType::PD) list.push_back({&branch, &point});
  std::stable_sort(list.begin(), list.end(),
                   [](const Place& a, const Place& b) { return a.point->after_point < b.point->after_point; });
  return list;
}

/// The distance between a doubled orbit and the orbit that is doubled at a point, up to a shift by forcing periods. The mean of
/// the doubled orbit's two halves is compared: near the point the halves differ from each other by much more than their mean
/// differs from the orbit.
double distance(const BranchPoint& doubled, const SpecialPoint& point) {
  const std::vector<Vector>& states = point.orbit.states;
  const std::size_t n = states.size();
  if (n == 0 || doubled.states.size() != 2 * n) return HUGE_VAL;
  double least = HUGE_VAL;
  for (std::size_t shift = 0; shift < n; ++shift) {
    double farthest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const Vector mean = 0.5 * (doubled.states[i] + doubled.states[i + n]);
      farthest = std::max(farthest, (mean - states[(i + shift) % n]).lpNorm<Eigen::Infinity>());
    }
    least = std::min(least, farthest);
  }
  return std::max(least, std::abs(doubled.value - point.value));
}

/// The far end of a doubled branch that has returned to orbits of half its period.
Place far_end(const std::vector<Branch>& branches, const Branch& doubled) {
  double least = 1e-2;  // branches stop short of the doubling, at a distance much smaller than that of other orbits
  Place nearest;
  if (doubled.stop != BranchStop::returned || doubled.points.empty()) return nearest;
  for (const Branch& branch : branches) {
    if (2 * branch.period != doubled.period) continue;
    for (const Place& place : doublings(branch)) {
      if (doubled.parent && doubled.parent->branch == branch.id && doubled.parent->label == place.point->label) continue;
      const double d = distance(doubled.points.back(), *place.point);
      if (d >= least) continue;
      least = d;
      nearest = place;
    }
  }
  return nearest;
}

/// The doublings that follow a place: the first one met on each branch with an end there.
std::vector<Place> next(const std::vector<Branch>& branches, const Place& place) {
  std::vector<Place> list;
  for (const Branch& branch : branches) {
    const std::vector<Place> met = doublings(branch);
    if (met.empty() || branch.period != 2 * place.branch->period) continue;
    const bool born = branch.parent && branch.parent->branch == place.branch->id && branch.parent->label == place.point->label;
    if (born)
      list.push_back(met.front());
    else if (far_end(branches, branch) == place)
      list.push_back(met.back());
  }
  return list;
}

void extend(const std::vector<Branch>& branches, const std::vector<Place>& chain, std::vector<Cascade>& found) {
  const std::vector<Place> following = next(branches, chain.back());
  for (const Place& place : following) {
    std::vector<Place> longer = chain;
    longer.push_back(place);
    extend(branches, longer, found);
  }
  if (!following.empty() || chain.size() < 3) return;
  Cascade cascade;
  for (const Place& place : chain)
    cascade.points.push_back({place.point->label, place.branch->id, place.branch->period, place.point->value});
  found.push_back(std::move(cascade));
}

}  // namespace

std::vector<double> Cascade::ratios() const {
  std::vector<double> list;
  for (std::size_t k = 1; k + 1 < points.size(); ++k)
    list.push_back((points[k].value - points[k - 1].value) / (points[k + 1].value - points[k].value));
  return list;
}

std::vector<Cascade> cascades(const std::vector<Branch>& branches) {
  std::vector<Place> all, later;
  for (const Branch& branch : branches)
    for (const Place& place : doublings(branch)) {
      all.push_back(place);
      const std::vector<Place> following = next(branches, place);
      later.insert(later.end(), following.begin(), following.end());
    }
  std::vector<Cascade> found;
  for (const Place& place : all)
    if (std::find(later.begin(), later.end(), place) == later.end()) extend(branches, {place}, found);
  return found;
}

const Columns<Doubling>& doubling_columns() {
  using D = Doubling;
  static const Columns<D> list = {{"label", "of the special point", &D::label},
                                  {"branch", "number of its branch", &D::branch},
                                  {"period", "period before the doubling", &D::period},
                                  {"value", "of the parameter", &D::value}};
  return list;
}

const Columns<Cascade>& cascade_columns() {
  static const Columns<Cascade> list = {
      {"points", "period doublings, each on the branch born at the one before", &Cascade::points},
      {"ratios", "of an interval between doublings to the next", &Cascade::ratios}};
  return list;
}

std::string cascades_text(const std::vector<Cascade>& list, const std::string& parameter) {
  std::string text;
  for (const Cascade& cascade : list) {
    Table table{{"generation", "point", "period", parameter, "interval", "ratio"}, {}};
    const std::vector<double> ratios = cascade.ratios();
    for (std::size_t k = 0; k < cascade.points.size(); ++k) {
      const Doubling& point = cascade.points[k];
      table.rows.push_back({std::to_string(k + 1), point.label, fmt::format("{} -> {}", point.period, 2 * point.period),
                            rounded(point.value, 12), k > 0 ? rounded(point.value - cascade.points[k - 1].value, 6) : "",
                            k > 1 ? rounded(ratios[k - 2], 5) : ""});
    }
    text += fmt::format("\ncascade of period doublings from {} of branch {} (ratio: an interval to the next; "
                        "Feigenbaum's constant {:.4f}):\n",
                        cascade.points.front().label, cascade.points.front().branch, feigenbaum) +
            aligned(table);
  }
  return text;
}

}  // namespace graze::apps
