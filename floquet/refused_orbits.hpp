// SPDX-License-Identifier: GPL-3.0-or-later
// RefusedOrbits: stable orbits that a motion passes by. To see that it does not come closer takes long where the orbit attracts
// weakly, and returns of the motion lead to the same orbit again and again.
#pragma once

#include <graze/floquet/distance_watch.hpp>
#include <graze/floquet/lane_orbits.hpp>
#include <graze/floquet/state_distance.hpp>

#include <algorithm>
#include <vector>

namespace graze {

class RefusedOrbits {
 public:
  /// The motion did not come closer to it from there.
  void add(const std::vector<StatePair>& orbit, const StatePair& from) {
    refused_.push_back({orbit.front(), nearest_distance(orbit, from)});
  }
  /// Whether that is so of this one, and it is not much nearer by now.
  bool knows(const std::vector<StatePair>& orbit, const StatePair& now) const {
    return std::any_of(refused_.begin(), refused_.end(), [&](const One& one) {
      return nearest_distance(orbit, one.state) < DistanceWatch::on_it && nearest_distance(orbit, now) > 0.5 * one.distance;
    });
  }

 private:
  struct One {
    StatePair state;
    double distance;
  };
  std::vector<One> refused_;
};

}  // namespace graze
