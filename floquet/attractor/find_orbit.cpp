// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/attractor/find_orbit.hpp>
#include <graze/floquet/orbit/returns.hpp>
#include <graze/floquet/orbit/stroboscopic_states.hpp>

#include <algorithm>
#include <stdexcept>

namespace graze {

namespace {

void take(FoundOrbits& found, std::vector<PeriodicOrbit> orbits, OrbitOrigin origin) {
  std::stable_partition(orbits.begin(), orbits.end(),
                        [](const PeriodicOrbit& orbit) { return orbit.admissible == Admissibility::admissible; });
  found.orbits = std::move(orbits);
  found.origin = origin;
}

/// The orbit that the settled motion repeats.
std::optional<PeriodicOrbit> settled_orbit(const HybridSystem& system, const Vector& p, const Settled& settled) {
  if (settled.suspected_period == 0) return std::nullopt;
  PeriodicOrbit orbit = shoot(system, p, settled.state, settled.suspected_period);
  if (!orbit.converged()) return std::nullopt;
  return orbit;
}

void search(const HybridSystem& system, const Vector& p, const FindOrbitOptions& options, FoundOrbits& found) {
  const auto cancelled = [&] { return options.search.cancelled && options.search.cancelled(); };
  SearchOptions searching = options.search;
  // The box first, and by runs that can be cancelled: where the forcing is slow, each of them takes its time.
  found.box = search_box(system, p, {.cancelled = options.settle.flow.cancelled});
  searching.lower = found.box->lower;
  searching.upper = found.box->upper;
  searching.max_steps = found.box->max_steps;
  found.cancelled = cancelled();
  if (found.cancelled || found.box->ended != Termination::time) return;
  found.search = search_orbits(system, p, options.period, searching);
  found.cancelled = cancelled();
  std::vector<PeriodicOrbit> orbits = std::move(found.search->orbits);
  for (PeriodicOrbit& orbit : orbits) orbit.checks.finite_difference = finite_difference_check(system, orbit);
  take(found, std::move(orbits), OrbitOrigin::search);
}

void find_autonomous(const HybridSystem& system, const Vector& p, const FindOrbitOptions& options, FoundOrbits& found) {
  if (found.settled->termination != Termination::time) return;
  Propagator propagator(system, p, {}, options.settle.flow);
  // The first of them brings the motion to a return, wherever it was before.
  std::vector<Vector> states =
      stroboscopic_states(propagator, found.settled->state, static_cast<std::size_t>(options.period) + 1);
  states.erase(states.begin());
  if (states.size() < static_cast<std::size_t>(options.period)) return;
  ShootingOptions shooting;
  shooting.finite_differences = true;
  PeriodicOrbit orbit = shoot_returns(propagator, states, shooting);
  if (orbit.converged()) {
    orbit.period = std::max(1, count_returns(system, orbit));
    if (orbit.period != options.period && !options.any_returns) {
      found.settled_on = std::move(orbit);
      return;
    }
    return take(found, {std::move(orbit)}, OrbitOrigin::settled);
  }
  orbit.state = states.front();
  found.attempted = std::move(orbit);
}

}  // namespace

const char* orbit_origin_name(OrbitOrigin origin) {
  return origin == OrbitOrigin::settled ? "settled" : origin == OrbitOrigin::search ? "search" : "";
}

FoundOrbits find_orbits(const HybridSystem& system, const Vector& p, const Vector& start, const FindOrbitOptions& options) {
  FoundOrbits found;
  if (options.search_only && !is_forced(system))
    throw std::invalid_argument(system.name +
                                " is autonomous, and the search is for forced systems; give a state near the orbit");
  if (options.search_only) {
    search(system, p, options, found);
    return found;
  }
  found.settled = settle(system, p, start, options.settle);
  found.cancelled = found.settled->termination == Termination::interrupted;
  if (found.cancelled) return found;
  if (!is_forced(system)) {
    find_autonomous(system, p, options, found);
    return found;
  }
  std::optional<PeriodicOrbit> fallback;
  if (found.settled->termination == Termination::time) {
    ShootingOptions shooting;
    shooting.finite_differences = true;
    PeriodicOrbit orbit = shoot(system, p, found.settled->state, options.period, shooting);
    const bool wanted = orbit.converged() && orbit.period == options.period && orbit.admissible == Admissibility::admissible;
    // Without a transient the state is the user's own guess; with one, the motion has not settled on an unstable orbit.
    if (wanted && (orbit.stable() || found.settled->suspected_period == options.period || options.settle.periods == 0)) {
      take(found, {std::move(orbit)}, OrbitOrigin::settled);
      return found;
    }
    if (wanted) fallback = std::move(orbit);
    found.settled_on = settled_orbit(system, p, *found.settled);
  }
  if (options.before_search) options.before_search(found);
  search(system, p, options, found);
  if (!found.found() && !found.cancelled && fallback) take(found, {std::move(*fallback)}, OrbitOrigin::settled);
  return found;
}

}  // namespace graze
