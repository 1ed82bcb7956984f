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
constexpr NewtonPatience patience{.max_halvings = 2};

/// The value at which the predictions end.
struct End {
  std::size_t at;
  bool is_before(std::size_t value) const { return at < value; }
  void move_to(std::size_t value) { at = std::min(at, value); }
};

MotionTask<> find(TaskSlot& slot, const Vector& p, std::size_t number, const Extrapolation& extrapolation, End& end,
                  Shot& found) {
  if (end.is_before(number)) co_return;
  slot.set_parameters(p);
  const States guess = extrapolation.at(number + 1);
  found = co_await shoot_from(slot, guess, patience);
  if (!found.converged) end.move_to(number);
}

/// Stores the orbit if the motion from `from` approaches it.
MotionTask<> approach(TaskSlot& slot, const Vector& p, std::size_t number, const Shot& found, Vector from, End& end,
                      PredictedOrbit& reached) {
  if (end.is_before(number)) co_return;
  slot.set_parameters(p);
  std::optional<StableOrbit> approached = co_await orbit_approached(slot, found, from);
  if (!approached) {
    end.move_to(number);
    co_return;
  }
  reached.orbit = std::move(*approached);
  reached.impact_speeds = co_await impact_speeds_of(slot, p, reached.orbit);
}

}  // namespace

MotionTask<std::vector<double>> impact_speeds_of(TaskSlot& slot, const Vector& p, const StableOrbit& orbit) {
  std::vector<double> out;
  if (orbit.whole) {
    for (const EventRecord& event : orbit.whole->events)
      if (begins_contact(event.kind)) out.push_back(event.normal_speed);
  } else if (orbit.impacts > 0) {
    slot.set_parameters(p);
    ImpactSpeeds speeds;
    co_await slot.carry(orbit.states.front(), static_cast<std::size_t>(orbit.period), &speeds);
    out = speeds.list();
  }
  co_return out;
}

std::vector<PredictedOrbit> predicted_orbits(const SharedSystem& system, const std::vector<std::vector<Vector>>& before,
                                             const std::vector<Vector>& next, const FlowOptions& flow) {
  if (before.size() < 2) return {};
  const Extrapolation extrapolation(before);
  TaskPool pool(system, flow);
  End end{next.size()};
  std::vector<Shot> found(next.size());
  pool.run(next.size(), [&](std::size_t i, TaskSlot& slot) { return find(slot, next[i], i, extrapolation, end, found[i]); });
  std::vector<PredictedOrbit> reached(end.at);
  pool.run(reached.size(), [&](std::size_t i, TaskSlot& slot) {
    const Vector from = i == 0 ? before.back().front() : found[i - 1].orbit.states.front();
    return approach(slot, next[i], i, found[i], from, end, reached[i]);
  });
  reached.resize(end.at);
  return reached;
}

}  // namespace graze
