// SPDX-License-Identifier: GPL-3.0-or-later
// Branch: a family of periodic orbits in one parameter, with its special points and the reason for its end. Times, states and
// speeds are dimensionless.
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
  reached_bound,    ///< end of the requested parameter range: the usual end
  parameter_range,  ///< end of the values that the model allows
  point_limit,      ///< largest number of points
  grazing,          ///< a hard contact grazes: the last special point, of type GR
  step_too_small,   ///< the corrector fails at the smallest step: see `message`
  chatter,          ///< sticking ends or begins: the chatter before it becomes incomplete or complete
  returned,         ///< back at its start, or at its parent branch
  equilibrium,      ///< the orbit of an autonomous system shrinks to an equilibrium: a Hopf point
  start_failed,     ///< no point could be computed
  interrupted       ///< cancelled before its end
};

/// The name of the enumerator: "reached_bound", ...
std::string_view branch_stop_name(BranchStop reason);

/// A point of a branch: a small record, sufficient to restart from it.
struct BranchPoint {
  double value = 0.0;          ///< of the continuation parameter
  double arclength = 0.0;      ///< from the start of the branch
  std::vector<Vector> states;  ///< at forcing phase 0 after 0 ... n - 1 periods
  std::vector<Vector> nodes;   ///< shooting nodes, equally spaced in time from section_phase on
  double section_phase = 0.0;  ///< of nodes[0], forcing phase over 2 pi
  double duration = 0.0;       ///< of the orbit
  FloquetMultipliers multipliers;
  Signature signature;
  int impacts = 0, isolated_impacts = 0;  ///< see PeriodicOrbit
  /// Scaled speed of its weakest event if the branch was followed in the coordinates of its events; otherwise infinity. Below
  /// 1e-5 a free run does not reproduce the orbit, because the arc beyond the barrier is no deeper than the accuracy of an
  /// impact.
  double weakest_speed = std::numeric_limits<double>::infinity();
  bool stable = false;
  Admissibility admissible = Admissibility::not_checked;
  OrbitChecks checks;
  OrbitShape shape;  ///< without nodes if the point was read from a file; shape_of computes it again
  const Vector& state() const { return states.front(); }
};

/// The special point on which a branch was born.
struct BranchParent {
  int branch = 0;     ///< Branch::id of the parent
  std::string label;  ///< of the special point on the parent
};

struct Branch {
  int id = 0;
  std::optional<BranchParent> parent;  ///< none: the branch starts from a seed
  int period = 0;                      ///< forcing periods; autonomous: see PeriodicOrbit::period
  int direction = 0;                   ///< direction of the first change of the parameter: -1 or +1
  std::string parameter;               ///< name of the continuation parameter
  Vector parameters;                   ///< values of all parameters; for the continuation parameter the value at the start
  std::vector<BranchPoint> points;
  std::vector<SpecialPoint> special_points;  ///< in order along the branch
  BranchStop stop = BranchStop::not_run;
  double stop_value = 0.0;  ///< parameter value at the last good point
  std::string message;      ///< the reason for the end in one sentence
  /// If set: the mirror image of the branch under this symmetry (floquet/orbit/mirror.hpp) is another branch, which is not
  /// listed.
  std::optional<Symmetry> mirrored = {};
  double time_carried = 0.0;                ///< dimensionless time simulated for the branch, as a measure of cost
  std::optional<BranchPoint> first_failed;  ///< last point tried, if the corrector failed there and the branch ended
};

/// Groups branches into curves. The two branches followed in both directions from one seed form one curve, because they have
/// their first orbit in common. Returns for each curve the indices of its branches (one or two), ordered by the first index.
std::vector<std::vector<std::size_t>> curves_of(const std::vector<Branch>& branches);

}  // namespace graze
