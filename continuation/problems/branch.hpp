// SPDX-License-Identifier: GPL-3.0-or-later
// Branch: a family of periodic orbits in one parameter, with its special points and the reason why it ends.
#pragma once

#include <graze/continuation/problems/special_point.hpp>
#include <graze/floquet/orbit/orbit_shape.hpp>
#include <graze/lib/system/symmetry.hpp>

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace graze {

enum class BranchStop {
  not_run,
  reached_bound,    ///< the end of the parameter's range: the usual end
  parameter_range,  ///< the end of what the model allows for the parameter
  point_limit,
  grazing,         ///< it ends where a hard contact grazes: its last special point of type GR
  step_too_small,  ///< the corrector fails at the smallest step: see `message`
  chatter,         ///< the mass no longer sticks, or begins to: the chatter before it becomes incomplete, or complete
  returned,        ///< back at its start, or at its parent branch
  start_failed,
  interrupted
};

std::string_view branch_stop_name(BranchStop reason);

/// A point of a branch: small, but enough to start from again.
struct BranchPoint {
  double value = 0.0;  ///< of the continuation parameter
  double arclength = 0.0;
  std::vector<Vector> states;  ///< at forcing phase 0 after 0 ... n - 1 periods
  std::vector<Vector> nodes;   ///< shooting nodes, from section_phase on
  double section_phase = 0.0;
  double duration = 0.0;
  FloquetMultipliers multipliers;
  Signature signature;
  int impacts = 0, isolated_impacts = 0;  ///< see PeriodicOrbit
  /// Normal speed of its weakest impact, where it was followed by its impacts. Below 1e-5 a free run does not reproduce the
  /// orbit, for its arc beyond the barrier is no deeper than what an impact is located to.
  double weakest_speed = std::numeric_limits<double>::infinity();
  bool stable = false;
  Admissibility admissible = Admissibility::not_checked;
  OrbitChecks checks;
  OrbitShape shape;  ///< without nodes where it was read from a file: shape_of gives it again
  const Vector& state() const { return states.front(); }
};

/// Where a branch was born: at a special point of another one.
struct BranchParent {
  int branch = 0;
  std::string label;
};

struct Branch {
  int id = 0;
  std::optional<BranchParent> parent;
  int period = 0;
  int direction = 0;      ///< in which the parameter first changes: -1 or +1
  std::string parameter;  ///< name of the continuation parameter
  Vector parameters;      ///< values of all; the continuation parameter's is that of the start
  std::vector<BranchPoint> points;
  std::vector<SpecialPoint> special_points;  ///< in the order met
  BranchStop stop = BranchStop::not_run;
  double stop_value = 0.0;  ///< of the parameter, at the last good point
  std::string message;      ///< the reason in a sentence
  /// Its mirror image under this symmetry (floquet/orbit/mirror.hpp) is another branch, which is not listed.
  std::optional<Symmetry> mirrored = {};
  double time_carried = 0.0;                ///< dimensionless time through which motion was computed for it: its cost
  std::optional<BranchPoint> first_failed;  ///< what was tried last, where the branch broke off
};

/// Branches followed both ways from one seed are one curve, with their first orbit in common: the places of the branches that
/// make up each curve, in the order of the first of them.
std::vector<std::vector<std::size_t>> curves_of(const std::vector<Branch>& branches);

}  // namespace graze
