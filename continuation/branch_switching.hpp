// SPDX-License-Identifier: GPL-3.0-or-later
// Where a branch that is born on another one begins: its first point, and the direction away from its birth.
#pragma once

#include <graze/continuation/grazing.hpp>
#include <graze/continuation/special_point.hpp>
#include <graze/continuation/trace.hpp>

#include <optional>

namespace graze {

struct BranchStart {
  Vector u, orientation = {};
  /// Set: u and orientation are in the coordinates of this signature (see SignatureEquations).
  std::optional<std::vector<std::size_t>> sequence = {};
  bool on_grazing = false;  ///< u is a grazing itself, which is no point of the branch
  double step = 0.0;  ///< first step of the tracer, where the usual one could pass over what lies close by; 0: the usual one
};

/// At a period doubling: the orbit run through twice, pushed apart along the eigenvector of -1. The corrector's arclength
/// condition keeps the push, so that it cannot fall back onto the parent. `doubled` has twice the nodes of `parent`.
std::optional<BranchStart> doubled_start(const SpecialPoint& pd, OrbitProblem& parent, OrbitProblem& doubled,
                                         const TraceOptions& options);

/// At the grazing of a hard contact: the orbits without the impact that was lost, or with the one that was gained, on the side of
/// the grazing on which they exist.
std::optional<BranchStart> partner_start(OrbitProblem& problem, const LocatedGrazing& grazing, bool lost,
                                         const TraceOptions& options);

/// Compares the side on which a doubled branch starts with the normal form's prediction, and says so in the details of `pd`.
void confirm_criticality(const Branch& child, SpecialPoint& pd, const Branch& parent);

}  // namespace graze
