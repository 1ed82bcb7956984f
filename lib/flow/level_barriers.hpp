// SPDX-License-Identifier: GPL-3.0-or-later
// Barriers of a mode whose guards are all levels of x, h = sign (x - level), for the flows that bound the motion between them.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <algorithm>
#include <vector>

namespace graze::detail {

struct LevelBarrier {
  std::size_t event = 0;  ///< index in HybridSystem::events
  double sign = 1.0, level = 0.0;
};

/// Whether all guards of the mode are such levels.
inline bool guards_are_levels(const HybridSystem& system, std::size_t mode) {
  return std::all_of(system.events.begin(), system.events.end(), [mode](const Event& event) {
    return event.from != mode || (event.guard.level && event.guard.level->coordinate == 0);
  });
}

/// The barriers of a mode for which guards_are_levels holds, at parameters p.
inline std::vector<LevelBarrier> level_barriers(const HybridSystem& system, std::size_t mode, const Vector& p) {
  std::vector<LevelBarrier> barriers;
  for (std::size_t i = 0; i < system.events.size(); ++i) {
    const Event& event = system.events[i];
    if (event.from == mode)
      barriers.push_back({i, event.guard.level->sign, p[static_cast<Eigen::Index>(event.guard.level->level)]});
  }
  return barriers;
}

}  // namespace graze::detail
