// SPDX-License-Identifier: GPL-3.0-or-later
// Where a branch that is born on another one begins: its first point, and the direction away from its birth.
#pragma once

#include <graze/continuation/conditions/grazing_edge.hpp>
#include <graze/continuation/problems/special_point.hpp>
#include <graze/continuation/trace/trace.hpp>

#include <optional>

namespace graze {

struct BranchStart {
  Vector u, orientation = {};
  /// Set: u and orientation are in the coordinates of this signature (see SignatureEquations).
  std::optional<std::vector<std::size_t>> sequence = {};
  std::vector<Vector> states = {};  ///< of a doubled orbit, at forcing phase 0
  bool on_grazing = false;          ///< u is a grazing itself, which is no point of the branch
  double step = 0.0;  ///< first step of the tracer, where the usual one could pass over what lies close by; 0: the usual one
};

/// At a period doubling: the orbit run through twice, pushed apart along the eigenvector of -1. The corrector's arclength
/// condition keeps the push, so that it cannot fall back onto the parent. An orbit with hard impacts is pushed in the coordinates
/// of its events. It is pushed so little that the doubled orbit has twice the impacts; empty if that is nowhere so, which means
/// that the period doubling lies on a grazing. `parent`: the equations of the orbit that doubles, in states.
std::optional<BranchStart> doubled_start(const SpecialPoint& pd, OrbitProblem& parent, const TraceOptions& options);

/// At a branch point: the other branch through it, on the side +1 or -1 (of a pitchfork: its two halves). The kernel of the
/// equations' Jacobian is spanned by the tangents of both branches; the start is pushed along what is normal to that of `branch`,
/// on which `bp` was met, and corrected there. Empty where no orbit with as many impacts is found. `states`: the equations of the
/// branch, in states.
std::optional<BranchStart> crossing_start(const SpecialPoint& bp, const Branch& branch, OrbitProblem& states, int side,
                                          const TraceOptions& options);

/// Contacts that may touch together.
inline constexpr int most_together = 8;

/// At the grazing of a hard contact: the orbits without the impact that was lost, or with the one that was gained, on the side of
/// the grazing on which they exist. Where these meet a barrier elsewhere at once, other contacts graze too (the orbit is
/// symmetric between two barriers): then the orbits with all of these impacts, if they are admissible.
std::optional<BranchStart> partner_start(OrbitProblem& problem, const LocatedGrazing& grazing, bool lost,
                                         const TraceOptions& options);

/// At the grazing of a hard contact, reduced to the least period of the orbit that touches: the orbits of pattern.turns >= 2
/// times that period with the weak impact in pattern.struck of the turns, on the side of the grazing on which their speeds are
/// positive. To first order the free maxima of the turns are a linear function of the speeds, h_i = h_top + sum R_(i-j) v_j: with
/// one impact h_i = -(R_0 - R_i) v, and the family is admissible where R_i < R_0 in all other turns. Empty where these pass the
/// barrier (decided on a solution 1e-6 away), where the orbit sticks elsewhere, or where the contact leads to another mode.
/// `problem`: of pattern.turns times the period.
std::optional<BranchStart> multiple_start(OrbitProblem& problem, const LocatedGrazing& grazing, TurnPattern pattern,
                                          const TraceOptions& options);

/// Compares the side on which a doubled branch lies that `begins` at `pd`, or ends there, with the normal form's prediction, and
/// says so in the details of `pd`.
void confirm_criticality(const Branch& child, SpecialPoint& pd, const Branch& parent, bool begins);

/// Decides between persistence and nonsmooth fold by the orbits themselves, those of the branch that `ended` on the grazing and
/// those of the one `beyond` (which begins there, or ends there too): they are admissible on different sides of it, or on the
/// same. Checked against the parity of multipliers beyond +1 (even, both families together: persistence; Feigin's rule) and
/// against the linear response, which stands where the others contradict it: a fold may lie between the grazing and the first
/// orbit kept. Written to the details of `grazing`.
void confirm_scenario(SpecialPoint& grazing, const Branch& ended, const Branch& beyond, bool begins);

}  // namespace graze
