// SPDX-License-Identifier: GPL-3.0-or-later
// Grazing: an orbit that touches a barrier with zero speed. Located by Newton on the extended system (Donde & Hiskens, Int. J.
// Bifurcation Chaos 16 (2006) 671)
//     H(u) = 0,   h(t_g, x(t_g)) = 0,   dh/dt(t_g, x(t_g)) = 0          unknowns u (orbit and parameter) and t_g,
// where the touching contact is left out: the motion is followed through the guard past t_g. The equations are then smooth, for
// soft and for hard contacts alike, although the return map is not: the derivative of a hard one grows like 1/speed.
#pragma once

#include <graze/continuation/problems/orbit_problem.hpp>

#include <optional>
#include <string_view>
#include <vector>

namespace graze {

/// Where an orbit (nearly) touches a guard.
struct GrazingGuess {
  std::size_t event = 0;          ///< whose guard
  int stretch = 0;                ///< of the shooting equations
  std::size_t events_before = 0;  ///< on that stretch
  double t = 0.0;                 ///< in the stretch's own time
  double t_resume = 0.0;          ///< guards are watched again from here
  double speed = 0.0;             ///< of the weak contact; 0 where it is a near miss
  double gap = 0.0;               ///< of the near miss, sampled; 0 where it is a contact
};

/// The weakest contact of the orbit at u, as a guess; empty if there is none.
std::optional<GrazingGuess> weakest_contact(OrbitProblem& problem, const Vector& u);

/// The `count` weakest contacts of the orbit at u, the weakest first; fewer if it has no more. A short flight between two soft
/// contacts counts as one: it is the excursion of a single contact that grazes from inside.
std::vector<GrazingGuess> weakest_contacts(OrbitProblem& problem, const Vector& u, int count);

/// The free maximum of a guard that comes nearest to it from below, as a guess; empty if there is none.
std::optional<GrazingGuess> nearest_miss(OrbitProblem& problem, const Vector& u);

/// All free maxima of a guard that come closer to it than `within`, the nearest first: of guards where a contact begins, and of
/// those where one ends, which are met where a mass first lifts off. A maximum may lie on an event: friction turns round where
/// the speed towards a stop vanishes.
std::vector<GrazingGuess> near_misses(OrbitProblem& problem, const Vector& u, double within);

struct LocatedGrazing {
  NewtonReport newton;
  Vector u;
  std::size_t event = 0;                    ///< whose guard is touched
  int touches = 1;                          ///< contacts that touch together, all of them left out
  double t = 0.0;                           ///< of the touch, from phase 0 of the orbit
  Vector touch;                             ///< the state there
  std::vector<std::size_t> contact_events;  ///< of a weak contact that leads through other modes, in order; else empty
  /// The contacts that touch as events of an orbit that has them: impacts, or entry and exit at once, of speed zero.
  std::vector<EventRecord> contacts;
  double precision = 0.0;     ///< estimated error of the parameter's value: rounding, or steps of a numerical flow
  bool others_vague = false;  ///< other contacts touch too: whether they are met hangs on the error of the flow
  double curvature = 0.0;     ///< d2h/dt2 at the touch, < 0
  PeriodicOrbit orbit;        ///< with the touching contact left out
  GrazingScenario scenario = GrazingScenario::unknown;
  bool leads_away = false;  ///< a weak contact leads to another mode, and not back from there at once
  Vector family_dp;         ///< du/d(parameter) of the orbits with that contact left out
  double top_dp = 0.0;      ///< d(h_top)/d(parameter) along them
  double response = 0.0;    ///< h_top per unit of impact speed at which the orbit with the impact exists
  Vector impulse;           ///< change of u (at fixed parameter) per unit of impact speed
  /// Of a hard contact: transition matrices from the touch to the end of its stretch, of the stretches that follow, and of the
  /// last one up to the touch; the guard's gradient there, and the change of state by an impact per unit of its speed.
  std::vector<Matrix> round;
  Vector gradient, kick;
};

/// `together`: contacts on other stretches that touch with this one (an orbit symmetric between two barriers) and are left out
/// too. The linear response is that to one impact alone: with them the scenario stays unknown. `missed`: free maxima on other
/// stretches that touch too, left out as well; the orbit has no contact there.
LocatedGrazing locate_grazing(OrbitProblem& problem, const Vector& u, const GrazingGuess& guess,
                              const std::vector<GrazingGuess>& together = {}, const std::vector<GrazingGuess>& missed = {});

}  // namespace graze
