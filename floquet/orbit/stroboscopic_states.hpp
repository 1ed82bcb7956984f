// SPDX-License-Identifier: GPL-3.0-or-later
// The states of a motion at forcing phase 0 in consecutive periods; for an autonomous system at its returns.
#pragma once

#include <graze/lib/motion/transition.hpp>

#include <vector>

namespace graze {

/// `count` states from `start` on; fewer if the motion cannot be continued.
inline std::vector<Vector> stroboscopic_states(Propagator& propagator, const Vector& start, std::size_t count) {
  Transition transition;
  std::vector<Vector> states{start};
  while (states.size() < count) {
    carry_period(propagator, states.back(), {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination != Termination::time) break;
    states.push_back(transition.x1);
  }
  return states;
}

}  // namespace graze
