// SPDX-License-Identifier: GPL-3.0-or-later
// Barriers of a mode whose guards are all levels of x, h = sign (x - level), for the flows that bound the motion between them.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <algorithm>
#include <cmath>
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

/// Whether the gap g with rate v and acceleration a has a maximum within rounding of the barrier. `scale`: of positions.
inline bool touches_by_rounding(double g, double v, double a, double scale) {
  return a < 0.0 && std::abs(g) < 4e-16 * scale && v * v < -a * 1e-14 * scale;
}

/// Time to the maximum of a gap with rate v and acceleration a, to second order; 0 if it lies behind or is no maximum.
inline double time_to_top(double v, double a) { return a < 0.0 ? std::max(0.0, -v / a) : 0.0; }

}  // namespace graze::detail
