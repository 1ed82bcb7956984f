// SPDX-License-Identifier: GPL-3.0-or-later
// Special points and their branches in the coordinates in which the branch was followed. Internal.
#pragma once

#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

#include <optional>

namespace graze {

/// A special point in the coordinates best suited to its branch: those of its events, if it has hard impacts and does not
/// stick.
struct OwnCoordinates {
  std::optional<SignatureProblem> by_events;
  Vector u;
};

OwnCoordinates own_coordinates(const SpecialPoint& point, OrbitProblem& states);

/// Direction from the branch's point before the special point to the one after it. The special point replaces a missing one.
Vector direction_along(const OwnCoordinates& own, OrbitProblem& states, const SpecialPoint& point, const Branch& branch);

}  // namespace graze
