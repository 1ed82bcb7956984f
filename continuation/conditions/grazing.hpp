// SPDX-License-Identifier: GPL-3.0-or-later
// Grazing: an orbit that touches a barrier with zero speed. Its defining equations are (Donde & Hiskens, Int. J. Bifurcation
// Chaos 16 (2006) 671)
//     H(u) = 0,   h(t_g, x(t_g)) = 0,   dh/dt(t_g, x(t_g)) = 0,
// with the unknowns u (orbit and parameter) and t_g. The touching contact is left out: the motion passes through the guard and
// continues past t_g. The equations are then smooth for soft and hard contacts. The return map of a hard contact is not smooth:
// its derivative grows like 1/speed.
//
// All times, states and speeds are dimensionless.
#pragma once

#include <graze/continuation/conditions/defining_equations.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

#include <memory>
#include <optional>
#include <string_view>
#include <vector>

namespace graze {

/// An instant at which an orbit touches a guard or nearly does, as a first guess for Newton's method.
struct GrazingGuess {
  std::size_t event = 0;          ///< index in HybridSystem::events; its guard is touched
  int stretch = 0;                ///< stretch of the shooting equations
  std::size_t events_before = 0;  ///< number of events on that stretch before the touch
  double t = 0.0;                 ///< of the touch, on the time axis of the stretch (ShootingEquations::node_time)
  double t_resume = 0.0;          ///< guards are ignored until this time (LeftOutContact)
  double speed = 0.0;             ///< normal speed of a weak contact; 0 for a near miss
  double gap = 0.0;               ///< distance of a near miss from the guard, from samples; 0 for a contact
};

/// The weakest contact of the orbit at u, as a guess. Empty if there is none, or if the equations cannot be evaluated.
std::optional<GrazingGuess> weakest_contact(OrbitProblem& problem, const Vector& u);

/// The `count` weakest contacts of the orbit at u, weakest first; fewer if the orbit has fewer. A short flight between two soft
/// contacts counts as a weak contact: it is the excursion of a single contact that grazes from inside.
std::vector<GrazingGuess> weakest_contacts(OrbitProblem& problem, const Vector& u, int count);

/// The free maximum of a guard function that is closest to zero from below, as a guess. Empty if there is none.
std::optional<GrazingGuess> nearest_miss(OrbitProblem& problem, const Vector& u);

/// All free maxima of guard functions that are closer to zero than `within`, nearest first. The guards are those that begin a
/// contact, and those that end one (reached when a mass first lifts off). A maximum may coincide with an event: friction
/// reverses when the speed towards a stop vanishes. Contacts slower than 1e-5 are listed too, with gap 0. If the motion cannot
/// be carried to the end, the list holds the maxima found so far.
std::vector<GrazingGuess> near_misses(OrbitProblem& problem, const Vector& u, double within);

struct LocatedGrazing {
  NewtonReport newton;
  bool confirmed = false;                   ///< converged to a maximum of the guard function that no other contact touches
  Vector u;                                 ///< unknowns of the orbit, the parameter's value last
  std::size_t event = 0;                    ///< index of the event whose guard is touched
  int touches = 1;                          ///< number of contacts that touch together; all are left out
  double t = 0.0;                           ///< time of the touch, from phase 0 of the orbit
  Vector touch;                             ///< state at the touch
  std::vector<std::size_t> contact_events;  ///< events of a weak contact that leads through other modes, in order; else empty
  /// The touching contacts as events of an orbit that has them, with speed zero: impacts, or an entry and an exit at one
  /// instant.
  std::vector<EventRecord> contacts;
  double precision = 0.0;     ///< estimated error of the parameter's value, by rounding and by the steps of a numerical flow
  bool others_vague = false;  ///< other contacts touch too, and the error of the flow decides whether they are met
  double curvature = 0.0;     ///< d2h/dt2 at the touch, < 0
  PeriodicOrbit orbit;        ///< with the touching contact left out
  GrazingScenario scenario = GrazingScenario::unknown;
  bool leads_away = false;  ///< a weak contact leads to another mode, and does not return at once
  Vector family_dp;         ///< du/d(parameter) along the family of orbits without the contact
  double top_dp = 0.0;      ///< d(h_top)/d(parameter) along this family; h_top: free maximum of the guard function
  double response = 0.0;    ///< h_top / (impact speed) at which the orbit with the impact exists, to first order
  Vector impulse;           ///< change of u at fixed parameter per unit of impact speed
  /// For a hard contact, once around the orbit: n x n transition matrices from the touch to the end of its stretch, over each
  /// following stretch, and over the first part of its stretch up to the touch.
  std::vector<Matrix> round;
  Vector gradient;  ///< of the guard function in the state, at the touch
  Vector kick;      ///< change of state by an impact, per unit of its speed
};

/// The defining equations of the touch at the guess; the contacts `others` on other stretches are left out too.
std::unique_ptr<DefiningEquations> grazing_equations(const GrazingGuess& guess, const std::vector<GrazingGuess>& others = {});

/// Newton's method on them from the orbit at u. The result is a grazing only if it is confirmed.
///
/// `together`: contacts on other stretches that touch together with this one (an orbit symmetric between two barriers). They
/// are left out too. The linear response describes a single impact, so that the scenario then stays unknown. `missed`: free
/// maxima on other stretches that touch too. They are also left out; the orbit has no contact there.
LocatedGrazing locate_grazing(OrbitProblem& problem, const Vector& start, const GrazingGuess& guess,
                              const std::vector<GrazingGuess>& together = {}, const std::vector<GrazingGuess>& missed = {});

}  // namespace graze
