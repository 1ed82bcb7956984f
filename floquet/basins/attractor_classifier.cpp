// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/distance_watch.hpp>
#include <graze/floquet/basins/attractor_classifier.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

constexpr double around = 0.06;      // farthest distance of a motion that may be settling on an orbit, relative to 1 + |x|
constexpr double same_state = 1e-6;  // orbits found by Newton to 1e-12 are the same if this close, relative to 1 + |x|

}  // namespace

std::vector<CellResidence> AttractorClassifier::residences() const {
  const auto aperiodic = [](const KnownAttractor& known) { return known.type != AttractorType::periodic; };
  return std::vector<CellResidence>(
      static_cast<std::size_t>(std::find_if(list_.rbegin(), list_.rend(), aperiodic).base() - list_.begin()));
}

std::vector<StateEllipse> AttractorClassifier::ellipses() const {
  std::vector<StateEllipse> all;
  for (const KnownAttractor& known : list_)
    for (const StateEllipse& one : known.orbit.ellipses()) all.push_back(one);
  return all;
}

std::optional<std::size_t> AttractorClassifier::reached(const Vector& state, std::vector<CellResidence>& residences) const {
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const KnownAttractor& known = list_[i];
    if (known.type == AttractorType::periodic ? known.orbit.holds(state) : residences[i].add(known.cells, state)) return i;
  }
  return std::nullopt;
}

std::optional<std::size_t> AttractorClassifier::orbit_at(const Vector& state, int period) const {
  for (std::size_t i = 0; i < list_.size(); ++i)
    if (list_[i].type == AttractorType::periodic && static_cast<int>(list_[i].orbit.centres.size()) == period &&
        list_[i].orbit.distance(state) < same_state * (1.0 + state.lpNorm<Eigen::Infinity>()))
      return i;
  return std::nullopt;
}

std::optional<ApproachTest> AttractorClassifier::nearing(const Vector& state, int period) const {
  std::optional<ApproachTest> nearest;
  double least = around * (1.0 + state.lpNorm<Eigen::Infinity>());
  for (std::size_t i = 0; i < list_.size(); ++i) {
    const TrappingRegion& orbit = list_[i].orbit;
    const int n = static_cast<int>(orbit.centres.size());
    if (list_[i].type != AttractorType::periodic || !(orbit.rate < 1.0) || period % n != 0) continue;
    const double distance = orbit.distance(state);
    if (!(distance < least)) continue;
    least = distance;
    nearest = {i, distance, n * std::ceil(std::log(0.5) / std::log(orbit.rate) / n)};
  }
  return nearest;
}

bool AttractorClassifier::has_come_closer(const ApproachTest& nearing, const Vector& state) const {
  return DistanceWatch::is_closer(list_[nearing.attractor].orbit.distance(state), nearing.times, nearing.distance);
}

bool AttractorClassifier::orbit_near(const Vector& state, double distance, bool with_region) const {
  return std::any_of(list_.begin(), list_.end(), [&](const KnownAttractor& known) {
    return known.type == AttractorType::periodic && (known.orbit.size > 0.0 || !with_region) &&
           known.orbit.distance(state) < distance;
  });
}

}  // namespace graze
