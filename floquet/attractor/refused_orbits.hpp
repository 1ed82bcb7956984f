// SPDX-License-Identifier: GPL-3.0-or-later
// RefusedOrbits: stable orbits that a motion passes without approaching them. Finding this out takes long if the orbit attracts
// weakly, and the returns of the motion lead to the same orbit again and again.
#pragma once

#include <graze/floquet/attractor/distance_watch.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/numerics/vector.hpp>

#include <algorithm>
#include <vector>

namespace graze {

class RefusedOrbits {
 public:
  /// Records that the motion from `from` did not approach the orbit with these states.
  void add(const std::vector<Vector>& orbit, const Vector& from) {
    refused_.push_back({orbit.front(), nearest_distance(orbit, from)});
  }
  /// Whether the orbit is recorded, and the motion is not much closer to it now.
  bool knows(const std::vector<Vector>& orbit, const Vector& now) const {
    return std::any_of(refused_.begin(), refused_.end(), [&](const One& one) {
      return nearest_distance(orbit, one.state) < DistanceWatch::rounding_distance &&
             nearest_distance(orbit, now) > 0.5 * one.distance;
    });
  }

 private:
  struct One {
    Vector state;
    double distance;
  };
  std::vector<One> refused_;
};

}  // namespace graze
