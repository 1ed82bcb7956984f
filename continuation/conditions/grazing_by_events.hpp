// SPDX-License-Identifier: GPL-3.0-or-later
// Grazings of hard contacts located from an orbit in the coordinates of its events, in which neither other weak impacts nor
// several that graze together make anything steep: first the speed goes to zero there, then the extended system (locate_grazing)
// gives the precision.
#pragma once

#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

namespace graze {

/// The grazing that Newton finds from a guess at u, if it lies right there.
std::optional<LocatedGrazing> grazing_near(OrbitProblem& problem, const Vector& u, const GrazingGuess& guess,
                                           const std::vector<GrazingGuess>& together = {},
                                           const std::vector<GrazingGuess>& missed = {});

/// The nearest grazing to the last orbit u of a branch that is not followed through it: of hard contacts, and of soft ones where
/// the system has both. Empty if none lies right there.
std::optional<LocatedGrazing> grazing_beside(OrbitProblem& problem, const Vector& u);

/// The grazing on which the motions of a branch end.
struct GrazingAhead {
  LocatedGrazing grazing;
  bool lost = false;  ///< an impact's speed goes to zero there; otherwise a free maximum reaches the barrier
  Vector u;           ///< there, in the coordinates of the branch
};

/// The grazing right beyond u, the last motion before `beyond`, no farther than `reach` in arclength. First by the speed of the
/// event that is lost or gained, in the coordinates of the events: of all that may graze, the one that lies right there. Where
/// other speeds go to zero with it, the contacts touch together (an orbit symmetric between two barriers): all of them are left
/// out, and counted (LocatedGrazing::touches). Free maxima that touch too are left out as well. Then the extended system
/// (locate_grazing) has to agree with that.
std::optional<GrazingAhead> grazing_ahead(SignatureProblem& problem, const Vector& u, const SignatureEquations::Violation& beyond,
                                          std::size_t parameter, double reach);

}  // namespace graze
