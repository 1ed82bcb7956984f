// SPDX-License-Identifier: GPL-3.0-or-later
// SignatureFollower: follows a branch of orbits with hard impacts in the coordinates of their signature, in which nothing is
// singular at a grazing. The branch ends at the grazing where the speed of an impact goes to zero or a flight reaches a barrier;
// the grazing is located. A branch may also begin on a grazing.
#pragma once

#include <graze/continuation/branch/branch_record.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

#include <optional>

namespace graze {

/// Least speed of the weakest impact for which an orbit is kept as a point of a branch (dimensionless). Below it a free run no
/// longer reproduces the orbit: the instant of the impact has error (rounding of the state) / (impact speed).
inline constexpr double least_kept_speed = 1e-5;

/// Speed below which an impact cannot be distinguished from rounding (dimensionless).
inline constexpr double least_resolved_speed = 1e-10;

class SignatureFollower {
 public:
  /// Refers to its arguments.
  SignatureFollower(const FollowSettings& settings, SignatureProblem& problem, BranchRecord& record);

  /// Follows the branch from `start`, in the coordinates of the problem.
  Curve follow(const BranchStart& start);

  /// On which the branch ended.
  const std::optional<GrazingEnd>& grazing() const { return grazing_; }
  /// Why the last trial solution is no motion; empty: it is one.
  const std::optional<SignatureEquations::Violation>& refused() const { return refused_; }
  /// For a branch that starts on a grazing: the orbit whose weakest impact is fastest, while no orbit is kept. Empty: none can
  /// be resolved.
  std::optional<Vector> fastest_point() const;

 private:
  Verdict monitor(const CurvePoint& before, CurvePoint& after);
  /// A branch that starts on a grazing begins with the first orbit beyond it whose impacts are fast enough. If the branch ends
  /// before (between two grazings close together, or at the end of the range), it keeps the orbit whose weakest impact is
  /// fastest.
  Verdict monitor_beyond_grazing(const CurvePoint& before, CurvePoint& after);
  /// Ends the branch at the grazing in the step, whose end is no motion. False: it cannot be located.
  bool reaches_grazing(const CurvePoint& before, CurvePoint& after);
  bool append_points_before_grazing(const Vector& grazing, CurvePoint& last);

  const FollowSettings& settings_;
  SignatureProblem& problem_;
  BranchRecord& record_;
  std::optional<SignatureEquations::Violation> refused_;
  std::optional<GrazingEnd> grazing_;
  // For a branch that starts on a grazing, until it has its first point:
  Vector beginning_;      ///< the grazing
  double fastest_ = 0.0;  ///< largest speed of the weakest impact so far
  Vector fastest_point_;
};

}  // namespace graze
