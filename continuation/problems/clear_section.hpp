// SPDX-License-Identifier: GPL-3.0-or-later
// Sections that stay clear of the events of an orbit.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

#include <vector>

namespace graze {

class OrbitProblem;

/// The widest gap between places on a circle of circumference 1. With the phases of the impacts (over 2 pi) as places, a section
/// in the middle of the gap stays clear of them.
struct Gap {
  double length = 0.0;
  double middle = 0.0;  ///< in [0, 2)
};

/// `places`: at least one, in [0, 1], ascending. Of gaps that are equal but for rounding (symmetric orbits) the one
/// across 0, else the first.
inline Gap widest_gap(const std::vector<double>& places) {
  constexpr double rounding = 1e-9;
  const double around = 1.0 - places.back() + places.front();
  Gap widest{around, places.back() + 0.5 * around};
  for (std::size_t i = 0; i + 1 < places.size(); ++i)
    if (places[i + 1] - places[i] > widest.length + rounding)
      widest = {places[i + 1] - places[i], 0.5 * (places[i] + places[i + 1])};
  return widest;
}

/// Phase of a section whose nodes on the orbit u stay clear of its events: the present one, or the middle of the widest gap if
/// that is much farther from them. Of an orbit without events, the place is avoided at which its first contact will appear.
double clear_section(OrbitProblem& problem, const Vector& u);

}  // namespace graze
