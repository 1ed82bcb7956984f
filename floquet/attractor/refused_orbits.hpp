// SPDX-License-Identifier: GPL-3.0-or-later
// RefusedOrbits: stable orbits that a motion passes by. To see that it does not come closer takes long where the orbit attracts
// weakly, and returns of the motion lead to the same orbit again and again.
#pragma once

#include <graze/floquet/attractor/distance_watch.hpp>
#include <graze/floquet/orbit/state_distance.hpp>
#include <graze/lib/numerics/vector.hpp>

#include <algorithm>
#include <vector>

namespace graze {

class RefusedOrbits {
 public:
  /// The motion did not come closer to an orbit of these states from there.
  template <class State> void add(const std::vector<State>& orbit, const Vector& from) {
    refused_.push_back({Vector(Eigen::Map<const Vector>(orbit.front().data(), from.size())), nearest_distance(orbit, from)});
  }
  /// Whether that is so of this one, and it is not much nearer by now.
  template <class State> bool knows(const std::vector<State>& orbit, const Vector& now) const {
    return std::any_of(refused_.begin(), refused_.end(), [&](const One& one) {
      return nearest_distance(orbit, one.state) < DistanceWatch::on_it && nearest_distance(orbit, now) > 0.5 * one.distance;
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
