// SPDX-License-Identifier: GPL-3.0-or-later
// Grazing: an orbit that touches a barrier with zero speed. Located by Newton on the extended system (Donde & Hiskens, Int. J.
// Bifurcation Chaos 16 (2006) 671)
//     H(u) = 0,   h(t_g, x(t_g)) = 0,   dh/dt(t_g, x(t_g)) = 0          unknowns u (orbit and parameter) and t_g,
// where the touching contact is left out: the motion is followed through the guard past t_g. The equations are then smooth, for
// soft and for hard contacts alike, although the return map is not: the derivative of a hard one grows like 1/speed.
#pragma once

#include <graze/continuation/orbit_problem.hpp>

#include <optional>
#include <string_view>

namespace graze {

/// Where an orbit (nearly) touches a guard.
struct GrazingGuess {
  std::size_t event = 0;          ///< whose guard
  int stretch = 0;                ///< of the shooting equations
  std::size_t events_before = 0;  ///< on that stretch
  double t = 0.0;                 ///< in the stretch's own time
  double t_resume = 0.0;          ///< guards are watched again from here
  double speed = 0.0;             ///< of the weak contact; 0 where it is a near miss
};

/// The weakest contact of the orbit at u, as a guess; empty if there is none.
std::optional<GrazingGuess> weakest_contact(OrbitProblem& problem, const Vector& u);

/// The free maximum of a guard that comes nearest to it from below, as a guess; empty if there is none.
std::optional<GrazingGuess> nearest_miss(OrbitProblem& problem, const Vector& u);

/// What lies beyond the grazing of a hard contact (Nordmark, J. Sound Vib. 145 (1991) 279; di Bernardo et al. 2008, ch. 7). To
/// first order in its speed v an orbit with the weak impact exists where the free maximum of the guard, continued as if nothing
/// were there, would be h_top = response v: beyond the barrier (response > 0: persistence, the impacting orbit takes over) or
/// short of it (response < 0: nonsmooth fold, the two annihilate). For one impact per n periods of a linear oscillator its sign
/// is that of sin(sqrt(1 - b^2) n T). Where the response is neither 0 nor infinite there is always such an orbit, and it is
/// admissible near the grazing: after the weak impact it leaves the barrier (curvature < 0), and all other impacts and maxima are
/// as good as those of the grazing orbit. Where several contacts touch at once (an orbit symmetric between two barriers) the
/// speeds v >= 0 solve a linear complementarity problem, R v >= h_top with equality where v > 0. The numbers of its solutions on
/// both sides of the grazing are both even or both odd, and the orbit without any impact is one of them: then too another family
/// begins, with one of the impacts or with several. `none`, no admissible orbit beyond the grazing, is left for contacts after
/// which the motion does not return, and for degenerate ones (R singular, curvature 0).
enum class GrazingScenario { unknown, smooth, persistence, nonsmooth_fold, none };
std::string_view grazing_scenario_name(GrazingScenario scenario);

struct LocatedGrazing {
  NewtonReport newton;
  Vector u;
  std::size_t event = 0;   ///< whose guard is touched
  double t = 0.0;          ///< of the touch, from phase 0 of the orbit
  Vector touch;            ///< the state there
  double precision = 0.0;  ///< estimated error of the parameter's value
  double curvature = 0.0;  ///< d2h/dt2 at the touch, < 0
  PeriodicOrbit orbit;     ///< with the touching contact left out
  GrazingScenario scenario = GrazingScenario::unknown;
  Vector family_dp;       ///< du/d(parameter) of the orbits with that contact left out
  double top_dp = 0.0;    ///< d(h_top)/d(parameter) along them
  double response = 0.0;  ///< h_top per unit of impact speed at which the orbit with the impact exists
  Vector impulse;         ///< change of u (at fixed parameter) per unit of impact speed
};

LocatedGrazing locate_grazing(OrbitProblem& problem, const Vector& u, const GrazingGuess& guess);

}  // namespace graze
