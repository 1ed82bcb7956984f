// SPDX-License-Identifier: GPL-3.0-or-later
// find_orbits: a periodic orbit of a given period from one start. The motion settles, then Newton's method is applied to the
// state that it has reached. If the attractor has another period, a global search follows.
#pragma once

#include <graze/floquet/attractor/search.hpp>
#include <graze/floquet/attractor/settle.hpp>

#include <functional>
#include <optional>

namespace graze {

enum class OrbitOrigin { none, settled, search };

/// "", "settled", "search".
const char* orbit_origin_name(OrbitOrigin origin);

struct FoundOrbits {
  OrbitOrigin origin = OrbitOrigin::none;
  std::vector<PeriodicOrbit> orbits;  ///< admissible ones first; from settling there is one
  bool cancelled = false;
  std::optional<Settled> settled;  ///< empty if only the search was asked for
  /// Orbit on which the motion settled, if it has another period. Of an autonomous system: the orbit near the settled state.
  std::optional<PeriodicOrbit> settled_on;
  std::optional<PeriodicOrbit> attempted;  ///< of an autonomous system: orbit that did not converge
  std::optional<SearchBox> box;            ///< of the search; box->ended other than `time`: nothing to search
  std::optional<SearchResult> search;      ///< its orbits have moved to `orbits`; empty if there was nothing to search
  bool found() const { return !orbits.empty() && orbits.front().admissible == Admissibility::admissible; }
};

struct FindOrbitOptions {
  int period = 1;            ///< in forcing periods, or returns of an autonomous system
  bool any_returns = false;  ///< of an autonomous system: an orbit with another number of returns is a result too
  SettleOptions settle;      ///< settle.cancelled is also asked before the search; settle.flow serves all runs
  SearchOptions search;      ///< its box is overwritten
  bool search_only = false;
  /// Called when the motion has settled on something else, before the search.
  std::function<void(const FoundOrbits&)> before_search = {};
};

/// Orbits of `options.period`, with finite-difference checks. An unstable orbit next to the settled state counts only if the
/// motion repeats itself with its period, or if there was no transient: the state is then a guess. Of an autonomous system, the
/// orbit that closes after `period` returns and after no fewer; there is no search. @throws std::invalid_argument for an
/// inadmissible start, and for search_only of an autonomous system.
FoundOrbits find_orbits(const HybridSystem& system, const Vector& p, const Vector& start, const FindOrbitOptions& options = {});

}  // namespace graze
