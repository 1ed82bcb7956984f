// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/apps/results/same_points.hpp>

#include <algorithm>
#include <cmath>

namespace graze::apps {

namespace {

/// Two locations of one orbit differ by rounding, amplified by a multiplier far from the unit circle: by less than this
/// relative to 1 + |x|. Different orbits at one value differ by more.
constexpr double same_state = 1e-6;
/// The same for values, beyond their stated errors: relative to 1 + |value|.
constexpr double same_value = 1e-12;

bool is_mark(PointType type) { return type == PointType::EP || type == PointType::UZ || type == PointType::MX; }

/// Compares states up to a shift by forcing periods; an orbit may be given over several times its period.
bool are_same_states(const std::vector<Vector>& a, const std::vector<Vector>& b) {
  const std::vector<Vector>&longer = a.size() < b.size() ? b : a, &shorter = a.size() < b.size() ? a : b;
  if (shorter.empty() || longer.size() % shorter.size() != 0) return false;
  for (std::size_t shift = 0; shift < shorter.size(); ++shift) {
    bool same = true;
    for (std::size_t k = 0; same && k < longer.size(); ++k) {
      const Vector& x = shorter[(k + shift) % shorter.size()];
      same = (longer[k] - x).lpNorm<Eigen::Infinity>() <= same_state * (1.0 + x.lpNorm<Eigen::Infinity>());
    }
    if (same) return true;
  }
  return false;
}

bool is_same(const SpecialPoint& a, const SpecialPoint& b) {
  const double error = a.precision + b.precision + same_value * (1.0 + std::abs(a.value));
  return a.type == b.type && std::abs(a.value - b.value) <= error && are_same_states(a.orbit.states, b.orbit.states);
}

}  // namespace

SamePoints same_points(const std::vector<Branch>& branches) {
  SamePoints same;
  std::vector<PointOfBranch> first;
  for (const Branch& branch : branches)
    for (const SpecialPoint& point : branch.special_points) {
      if (is_mark(point.type)) continue;
      const auto found = std::find_if(first.begin(), first.end(), [&](const PointOfBranch& other) {
        return other.branch != &branch && is_same(*other.point, point);
      });
      if (found != first.end())
        same.emplace(&point, *found);
      else
        first.push_back({&branch, &point});
    }
  return same;
}

void put_same_points(Json& list, const std::vector<Branch>& branches) {
  const SamePoints same = same_points(branches);
  for (std::size_t i = 0; i < branches.size(); ++i)
    for (std::size_t k = 0; k < branches[i].special_points.size(); ++k)
      if (const auto found = same.find(&branches[i].special_points[k]); found != same.end())
        list[i]["special_points"][k]["same_as"] = {{"branch", found->second.branch->id}, {"label", found->second.point->label}};
}

}  // namespace graze::apps
