// SPDX-License-Identifier: GPL-3.0-or-later
// Location of a grazing of a hard contact from an orbit in the coordinates of its events. In these coordinates nothing becomes
// steep if other impacts are weak, or if several contacts graze together. The method has two steps: Newton's method in these
// coordinates finds the orbit with speed zero, and its defining equations (locate_grazing) confirm it and give the precision.
#pragma once

#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

namespace graze {

/// The grazing that Newton's method finds from a guess at u. Empty if the method fails, or if the grazing is farther away than
/// 0.02 in arclength. `together`, `missed`: see locate_grazing.
std::optional<LocatedGrazing> grazing_near(OrbitProblem& problem, const Vector& u, const GrazingGuess& guess,
                                           const std::vector<GrazingGuess>& together = {},
                                           const std::vector<GrazingGuess>& missed = {});

/// The grazing nearest to u, the last orbit of a branch that cannot be followed through it. Grazings of soft contacts are
/// considered only if the system has hard contacts too. Empty if there is none within 0.02 in arclength.
std::optional<LocatedGrazing> grazing_beside(OrbitProblem& problem, const Vector& u);

/// The grazing at which a branch of admissible motions ends.
struct GrazingAhead {
  LocatedGrazing grazing;
  bool lost = false;  ///< the speed of an impact goes to zero; otherwise a free maximum reaches the barrier
  Vector u;           ///< the grazing orbit in the coordinates of the branch
};

/// The grazing just beyond u, the last admissible motion before the violation `beyond`, at most `reach` away in arclength.
///
/// First the speed of the lost or gained event is set to zero in the coordinates of the events; the candidate must lie within
/// `reach`. If other speeds vanish with it, the contacts touch together (an orbit symmetric between two barriers): all are left
/// out and counted (LocatedGrazing::touches). Free maxima that touch too are also left out. Then the extended system
/// (locate_grazing) must give the same parameter value. Empty if no candidate passes.
std::optional<GrazingAhead> grazing_ahead(SignatureProblem& problem, const Vector& u, const SignatureEquations::Violation& beyond,
                                          double reach);

}  // namespace graze
