// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/known_attractors.hpp>

#include <algorithm>

namespace graze {

namespace {

constexpr double same_state = 1e-6;  // two orbits found by Newton to 1e-12 are one if they come so close, relative to 1 + |x|

}  // namespace

std::optional<std::size_t> KnownAttractors::reached(const Vector& state, std::vector<Strand>& strands) const {
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const KnownAttractor& known = list_[i];
    if (known.type == AttractorType::periodic ? known.orbit.holds(state) : strands[i].add(known.cells, state)) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> KnownAttractors::orbit_at(const Vector& state, int period) const {
  for (std::size_t i = 0; i < list_.size(); ++i)
    if (list_[i].type == AttractorType::periodic && static_cast<int>(list_[i].orbit.centres.size()) == period &&
        list_[i].orbit.distance(state) < same_state * (1.0 + state.lpNorm<Eigen::Infinity>()))
      return i;
  return std::nullopt;
}

std::optional<std::size_t> KnownAttractors::orbit_around(const Vector& state, int period, double distance) const {
  std::optional<std::size_t> nearest;
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const TrappingRegion& orbit = list_[i].orbit;
    if (list_[i].type != AttractorType::periodic || !(orbit.rate < 1.0)) continue;
    if (period % static_cast<int>(orbit.centres.size()) != 0 || !(orbit.distance(state) < distance)) continue;
    distance = orbit.distance(state);
    nearest = i;
  }
  return nearest;
}

bool KnownAttractors::orbit_near(const Vector& state, double distance, bool with_region) const {
  return std::any_of(list_.begin(), list_.end(), [&](const KnownAttractor& known) {
    return known.type == AttractorType::periodic && (known.orbit.size > 0.0 || !with_region) &&
           known.orbit.distance(state) < distance;
  });
}

}  // namespace graze
