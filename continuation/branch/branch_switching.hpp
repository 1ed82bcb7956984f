// SPDX-License-Identifier: GPL-3.0-or-later
// Branches that begin at the grazing of a hard contact (those born at other special points: TestFunction::born).
#pragma once

#include <graze/continuation/conditions/birth.hpp>
#include <graze/continuation/conditions/grazing_edge.hpp>

#include <optional>

namespace graze {

/// Largest number of contacts that may graze together.
inline constexpr int max_simultaneous_contacts = 8;

/// At the grazing of a hard contact: the orbits without the lost impact, or with the gained one, on the side of the grazing on
/// which they exist. If the orbits with the gained impact immediately meet a barrier elsewhere, other contacts graze too (the
/// orbit is symmetric between two barriers); then the result is the orbits with all of these impacts, if they are admissible.
std::optional<BranchStart> partner_start(OrbitProblem& problem, const LocatedGrazing& grazing, bool lost,
                                         const TraceOptions& options);

/// At the grazing of a hard contact that an orbit symmetric in itself gains: the orbits that gain it and its images together.
/// Empty if there is no image, if these orbits meet a barrier elsewhere at once, and where partner_start() needs other
/// coordinates than those of the events.
std::optional<BranchStart> symmetric_start(OrbitProblem& problem, const LocatedGrazing& grazing, const TraceOptions& options);

/// At the grazing of a hard contact, reduced to the least period of the grazing orbit: the orbits of pattern.turns >= 2 times
/// that period with the weak impact in pattern.struck of the turns, on the side of the grazing on which its speeds are
/// positive. To first order the free maxima of the turns are linear in the speeds, h_i = h_top + sum R_(i-j) v_j. With one
/// impact h_i = -(R_0 - R_i) v, and the family is admissible if R_i < R_0 in all other turns. Empty if these maxima pass the
/// barrier (decided on a solution 1e-6 away), if the orbit sticks elsewhere, or if the contact leads to another mode.
/// `problem`: equations for pattern.turns times the period.
std::optional<BranchStart> multiple_start(OrbitProblem& problem, const LocatedGrazing& grazing, TurnPattern pattern,
                                          const TraceOptions& options);

/// Decides between persistence and nonsmooth fold from the orbits of the branch that `ended` on the grazing and of the one
/// `beyond` (which begins there if `begins`, otherwise ends there): persistence if they are admissible on different sides of
/// the grazing, fold if on the same side. Two checks: the parity of multipliers beyond +1 (even, both families together:
/// persistence; Feigin's rule), and the linear response. The response takes precedence if the others contradict it, because a
/// smooth fold may lie between the grazing and the first orbit kept. Writes to the details of `grazing`, with
/// the impacts of the branch beyond: if several contacts touch together (an orbit symmetric between two barriers), it may have
/// one more impact, or as many more as contacts touch.
void confirm_scenario(SpecialPoint& grazing, const Branch& ended, const Branch& beyond, bool begins);

}  // namespace graze
