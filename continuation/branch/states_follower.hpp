// SPDX-License-Identifier: GPL-3.0-or-later
// StatesFollower: follows a branch in the states of its orbits at fixed phases: orbits with soft contacts, with sticking or
// without impacts. Steps are shortened until they cross one grazing at a time. The branch continues beyond the kinks of friction
// and beyond the corner at the grazing of a stiff contact; it ends where a hard contact gains or loses an impact, where a chatter
// becomes complete, and at an equilibrium.
#pragma once

#include <graze/continuation/branch/branch_record.hpp>
#include <graze/continuation/problems/orbit_problem.hpp>

namespace graze {

/// True if the restitution is zero (k_r = 0): each impact is its own complete chatter, and the mass leaves as soon as no force
/// presses it to the barrier. The state changes continuously there.
bool is_plastic(const HybridSystem& system, const Vector& p);

class StatesFollower {
 public:
  /// Refers to its arguments. The problem is moved to sections clear of impacts.
  StatesFollower(const FollowSettings& settings, OrbitProblem& problem, BranchRecord& record);

  /// Follows the branch from `given`; the record is empty or ends there.
  Curve follow(const BranchStart& given);

 private:
  Verdict monitor(const CurvePoint& before, CurvePoint& after);
  double better_section(const Vector& u) const;
  /// Steps over a kink at the end of the branch: `last` becomes the first point beyond it.
  bool step_over_kink(CurvePoint& last);
  /// Appends the first point beyond a kink, and the kink as a grazing, if it is one: events that pass a node or change places
  /// make none. No test function is continuous across it.
  void append_beyond_kink(const Vector& u, BranchPoint point, bool goes_on);
  /// From the last point on, pins the place of the bodies that friction holds. Returns the direction in which the parameter
  /// grows.
  Vector pin_held_states();

  const FollowSettings& settings_;
  OrbitProblem& problem_;
  BranchRecord& record_;
  bool clear_of_soft_ = false;    // nodes stay clear of soft contacts too
  bool section_blocked_ = false;  // an impact is too close to a node
  bool holds_more_ = false;       // at the last step friction begins to hold a body all along
};

}  // namespace graze
