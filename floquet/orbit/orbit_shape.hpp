// SPDX-License-Identifier: GPL-3.0-or-later
// OrbitShape: an orbit described by quantities that are continuous along its branch, for the comparison of orbits.
//
// The state at a fixed phase jumps when a hard impact passes that phase. The times of the hard events and the states just
// before them do not jump: they are the nodes of an orbit with hard events. The nodes of an orbit that sticks are the ends of
// its sticking phases (the number of impacts between them depends on the definition). An orbit without hard events has its
// states at phase 0 as nodes or, without forcing, its other events.
#pragma once

#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <optional>
#include <vector>

namespace graze {

struct OrbitShape {
  struct Node {
    std::size_t event = 0;  ///< index in HybridSystem::events; for a state at phase 0 one past the last
    double time = 0.0;      ///< in forcing periods (autonomous: in durations of the orbit)
    Vector state;
  };
  int period = 0;
  bool autonomous = false;  ///< the origin of time is arbitrary
  bool sticks = false;
  std::vector<Node> nodes;

  /// Whether the nodes are the hard events of an orbit that does not stick.
  bool by_events(const HybridSystem& system) const {
    return !sticks && !nodes.empty() && nodes.front().event < system.events.size();
  }
};

OrbitShape shape_of(const HybridSystem& system, const PeriodicOrbit& orbit);

/// The same from the states at phase 0 of the orbit's periods, by a free run from each; `duration` of the whole orbit. Empty
/// nodes: the motion cannot be carried so far.
OrbitShape shape_of(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states, double duration);

/// `b`, with its nodes rotated and shifted by whole forcing periods so that it is closest to `a`. Empty if the two have
/// different periods or events.
struct AlignedShape {
  OrbitShape shape;
  double distance = 0.0;  ///< largest difference of times (in radians of the period) and of states, relative to 1 + |x|
};
std::optional<AlignedShape> aligned(const OrbitShape& b, const OrbitShape& a);

inline constexpr double same_orbit_tolerance = 1e-8;

/// True if a and b, at the same parameters, are the same orbit: they have the same period, and a state at phase 0 or else all
/// events agree within tolerance (1 + |x|).
bool same_orbit(const PeriodicOrbit& a, const PeriodicOrbit& b, double tolerance = same_orbit_tolerance);

/// True if a and b, at the same parameters, are orbits on which friction holds a body all along, and differ in its place alone:
/// they belong to one continuum.
bool same_but_place(const PeriodicOrbit& a, const PeriodicOrbit& b);

}  // namespace graze
