// SPDX-License-Identifier: GPL-3.0-or-later
// Birth: a branch of orbits that is born at a special point of another one: its first point, and the direction away from there.
#pragma once

#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/trace/trace.hpp>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace graze {

class OrbitProblem;

/// The first point of a branch. In states, the unknowns are those of OrbitProblem::repeated(Birth::multiple).
struct BranchStart {
  Vector u;                 ///< solution of the equations of the branch
  Vector orientation = {};  ///< direction in which the branch is followed, in the same unknowns
  /// If set, u and orientation are in the coordinates of these events (BranchProblem::sequence). Empty: in states.
  std::optional<std::vector<std::size_t>> sequence = {};
  std::vector<Vector> states = {};  ///< of an orbit beside the birth, at forcing phase 0
  bool on_grazing = false;          ///< u is the grazing itself, which is not a point of the branch
  double step = 0.0;                ///< first step of the tracer; 0: the default one, which may step over nearby special points
};

struct Birth {
  int multiple = 1;              ///< its period over that of the orbit at the point
  std::vector<int> sides = {1};  ///< a branch begins on each
  bool located_only = false;     ///< no branch is started at a point that is only bracketed
  /// The branch exists: if its start is not found, it is listed as failed. Otherwise the point is listed as cut off.
  bool certain = false;
  std::string missing = {};  ///< message if the start is not found
  /// The first point on a side. `on`: the branch with the point; `states`: equations of the orbit there, in states. The orbit's
  /// unknowns are states.pack(point.orbit.nodes, point.orbit.duration, point.value). Empty if no first point is found.
  std::function<std::optional<BranchStart>(const SpecialPoint& point, const Branch& on, OrbitProblem& states, int side,
                                           const TraceOptions& options)>
      start = {};
  /// Compares the branch with the description of the point, and writes the result to its details. `begins`: the branch begins
  /// at the point; otherwise it ends there. Empty: there is nothing to compare.
  std::function<void(const Branch& child, SpecialPoint& point, const Branch& on, bool begins)> confirm = {};
};

}  // namespace graze
