// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/settling_orbit.hpp>
#include <graze/floquet/follow/predicted_orbits.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/tasks/task_pool.hpp>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

namespace graze {

namespace {

using States = std::vector<Vector>;

/// The same orbit, rotated so that its states are closest to those of another.
States rotated_to(const States& other, const States& states) {
  const std::size_t n = states.size();
  States best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t first = 0; first < n; ++first) {
    double apart = 0.0;
    for (std::size_t k = 0; k < n; ++k) apart = std::max(apart, state_distance(states[(first + k) % n], other[k]));
    if (apart >= least) continue;
    least = apart;
    best.clear();
    for (std::size_t k = 0; k < n; ++k) best.push_back(states[(first + k) % n]);
  }
  return best;
}

/// The polynomial through orbits at equidistant values, by backward differences at the last of them.
class Extrapolation {
 public:
  explicit Extrapolation(const std::vector<States>& before) {
    std::vector<States> row;  // latest first
    for (auto orbit = before.rbegin(); orbit != before.rend() && row.size() < most_orbits_before; ++orbit)
      row.push_back(row.empty() ? *orbit : rotated_to(row.back(), *orbit));
    while (!row.empty()) {
      differences_.push_back(row.front());
      for (std::size_t i = 0; i + 1 < row.size(); ++i)
        for (std::size_t k = 0; k < row[i].size(); ++k) row[i][k] -= row[i + 1][k];
      row.pop_back();
    }
  }
  /// States at this many values beyond the last.
  States at(std::size_t steps) const {
    States states = differences_.front();
    double weight = 1.0;  // binomial(steps + j - 1, j)
    for (std::size_t j = 1; j < differences_.size(); ++j) {
      weight *= static_cast<double>(steps + j - 1) / static_cast<double>(j);
      for (std::size_t k = 0; k < states.size(); ++k) states[k] += weight * differences_[j][k];
    }
    return states;
  }

 private:
  std::vector<States> differences_;
};

/// Guesses that are not close are abandoned; direct simulation handles those values.
constexpr LanePatience patience{.max_halvings = 2};

/// Stores the orbit if the motion from `from` approaches it.
MotionTask<> approach(TaskSlot& lane, const HybridSystem& system, std::size_t parameters, const Vector& p, const LaneOrbit& orbit,
                      Vector from, PredictedOrbit& reached) {
  lane.set_parameters(parameters);
  std::optional<StableOrbit> approached = co_await orbit_approached_in_lanes(lane, system, p, orbit, from);
  if (!approached) co_return;
  reached.orbit = std::move(*approached);
  if (reached.orbit.impacts == 0) co_return;
  ImpactSpeeds speeds;
  co_await lane.carry(reached.orbit.states.front(), static_cast<std::size_t>(reached.orbit.period), &speeds);
  reached.impact_speeds = speeds.list();
}

}  // namespace

std::vector<PredictedOrbit> predicted_orbits(const HybridSystem& system, const std::vector<std::vector<Vector>>& before,
                                             const std::vector<Vector>& next, const FlowOptions& flow) {
  if (before.size() < 2) return {};
  const std::unique_ptr<LaneCarrier> many = make_lane_carrier(system, next, flow);
  if (!many) return {};
  const Extrapolation extrapolation(before);
  std::vector<LaneGuess> guesses;
  for (std::size_t i = 0; i < next.size(); ++i) guesses.push_back(guess_of(i, extrapolation.at(i + 1)));
  std::vector<LaneOrbit> found = shoot_together(*many, guesses, patience);
  const auto missing = std::find_if(found.begin(), found.end(), [](const LaneOrbit& orbit) { return !orbit.converged; });
  found.erase(missing, found.end());
  std::vector<PredictedOrbit> reached(found.size());
  TaskPool(*many).run(found.size(), [&](std::size_t i, TaskSlot& lane) {
    const Vector from = i == 0 ? before.back().front() : vector_of(found[i - 1].states.front());
    return approach(lane, system, i, next[i], found[i], from, reached[i]);
  });
  const auto not_reached = [](const PredictedOrbit& ahead) { return ahead.orbit.states.empty(); };
  reached.erase(std::find_if(reached.begin(), reached.end(), not_reached), reached.end());
  return reached;
}

}  // namespace graze
