// SPDX-License-Identifier: GPL-3.0-or-later
// A grazing as a special point of a branch. It is one object, as other bifurcations are by their TestFunction, in files of its
// own:
//
//     detection    grazing_in_step (the number of impacts changes between two points); grazing_ahead (along a branch of hard
//                  contacts a solution is no motion), grazing_beside (the branch breaks off): grazing_by_events.hpp
//     equations    grazing_equations, which locate_grazing solves: grazing.hpp
//     description  grazing_point
//     families     birth_at_grazing, confirm_scenario: grazing_families.hpp
//
// It is no TestFunction, because no scalar changes its sign there: a hard contact ends the family of orbits, and several families
// begin.
#pragma once

#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/problems/special_point.hpp>
#include <graze/continuation/trace/trace.hpp>

namespace graze {

/// The special point of a located grazing at the end of the branch so far, where the number of impacts changes.
SpecialPoint grazing_point(const HybridSystem& system, const LocatedGrazing& located, int impacts_before, int impacts_after,
                           const Branch& branch);

/// A grazing within a step of a branch; `u` is the orbit there.
struct GrazingInStep {
  Vector u;
  SpecialPoint point;
};

/// The grazing at which the number of impacts changes in the step from `before`, the end of the branch so far, to `reached`, or
/// its bracket.
GrazingInStep grazing_in_step(OrbitProblem& problem, const CurvePoint& before, const CurvePoint& after,
                              const BranchPoint& reached, const Branch& branch);

}  // namespace graze
