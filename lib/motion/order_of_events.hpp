// SPDX-License-Identifier: GPL-3.0-or-later
// Events that fall on one instant, such as two stops that are hit together, fire in the order in which they are declared. Where
// the resets do not commute, another order leads to another state.
#pragma once

#include <graze/lib/motion/trajectory.hpp>

#include <vector>

namespace graze {

/// Two simultaneous events, and the states right after them with either event first.
struct OrderedPair {
  std::size_t first = 0, second = 0;  ///< indices in HybridSystem::events, in the order of the run
  double t = 0.0;
  Vector x_minus, x_plus, x_plus_other;
};

/// Pairs of simultaneous events whose order changes the state, each pair of names once. `events` are those of a run of the
/// system, in order.
std::vector<OrderedPair> noncommuting_events(const HybridSystem& system, const Vector& p, const std::vector<EventRecord>& events);

}  // namespace graze
