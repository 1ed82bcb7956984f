// SPDX-License-Identifier: GPL-3.0-or-later
// OrbitShape: an orbit in what is continuous along its branch, by which orbits are compared.
//
// The state at a fixed phase jumps where a hard impact passes that phase. The instants of the hard events and the states just
// before them do not: they are the nodes of an orbit that has any. An orbit that sticks is known by the ends of its sticking
// (between them the number of impacts is a matter of definition), one without hard events by its states at phase 0, or, without
// forcing, by its other events.
#pragma once

#include <graze/floquet/orbit/periodic_orbit.hpp>

#include <optional>
#include <vector>

namespace graze {

struct OrbitShape {
  struct Node {
    std::size_t event = 0;  ///< index in HybridSystem::events; of a state at phase 0 one beyond the last
    double time = 0.0;      ///< in forcing periods (autonomous: in durations of the orbit)
    Vector state;
  };
  int period = 0;
  bool autonomous = false;  ///< instants count from anywhere
  bool sticks = false;
  std::vector<Node> nodes;

  /// Its nodes are the hard events of an orbit that does not stick.
  bool by_events(const HybridSystem& system) const {
    return !sticks && !nodes.empty() && nodes.front().event < system.events.size();
  }
};

OrbitShape shape_of(const HybridSystem& system, const PeriodicOrbit& orbit);

/// The same from the states at phase 0 of the orbit's periods, by a free run from each of them; `duration` of the whole orbit.
/// Empty nodes: the motion cannot be carried so far.
OrbitShape shape_of(const HybridSystem& system, const Vector& p, const std::vector<Vector>& states, double duration);

/// `b` with its nodes counted from another one, and by whole forcing periods, so that it comes nearest to `a`. Empty where the
/// two have other periods or other events.
struct AlignedShape {
  OrbitShape shape;
  double distance = 0.0;  ///< largest difference of instants (in radians of the period) and of states, relative to 1 + |x|
};
std::optional<AlignedShape> aligned(const OrbitShape& b, const OrbitShape& a);

/// True if a and b, at the same parameters, are the same orbit: they have the same period, and a state at phase 0 or else all
/// events agree within tolerance (1 + |x|).
bool same_orbit(const PeriodicOrbit& a, const PeriodicOrbit& b, double tolerance = 1e-8);

}  // namespace graze
