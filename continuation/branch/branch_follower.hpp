// SPDX-License-Identifier: GPL-3.0-or-later
// BranchFollower: one branch from its start to its end: the tracer with a monitor that watches the range, the test functions, the
// impacts and the return to a parent, and that locates what it meets.
//
// Orbits with hard impacts are followed in the coordinates of their signature, in which nothing is singular at a grazing; where
// one impact's speed goes to zero, or a flight meets the barrier, the grazing is located and the branch ends there. All other
// orbits (soft contacts, sticking, no impact) are followed in their states at fixed phases.
#pragma once

#include <graze/continuation/branch/branch_switching.hpp>
#include <graze/continuation/branch/continuation_options.hpp>
#include <graze/continuation/conditions/grazing.hpp>
#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

namespace graze {

/// Speed of the weakest impact of an orbit that is kept as a point of a branch. Below it a free run no longer reproduces the
/// orbit: rounding of the state over that speed is what the instant of the impact is known to.
inline constexpr double weakest_kept = 1e-5;

/// Speed below which that of an impact cannot be told from rounding.
inline constexpr double weakest_told = 1e-10;

struct GrazingEnd {
  LocatedGrazing grazing;
  bool lost = false;  ///< the branch had the impact; otherwise the orbits beyond gain it
};

/// A special point met within a step: `place` along the step orders it among the others, `u` is the orbit there.
struct MetPoint {
  double place = 0.0;
  Vector u;
  SpecialPoint point;
};

class BranchFollower {
 public:
  /// `low`, `high`: the range of the parameter.
  BranchFollower(const HybridSystem& system, const ContinuationOptions& options, double low, double high);

  /// Follows the branch from `start` into `branch` (parent, period and parameters are set; its special points get no labels
  /// here). Returns the grazing on which it ended, if so.
  std::optional<GrazingEnd> follow(OrbitProblem& problem, const BranchStart& start, Branch& branch);

 private:
  // The two ways of following, and what both do at each step.
  Curve follow_states(OrbitProblem& problem, const BranchStart& given, Branch& branch);
  Curve follow_signature(SignatureProblem& problem, const BranchStart& start, Branch& branch);
  std::optional<BranchStart> goes_on_in_states(OrbitProblem& problem, const SignatureProblem& signature, const Curve& curve,
                                               const Branch& branch) const;
  bool around_corner(OrbitProblem& problem, Branch& branch, CurvePoint& last);
  Verdict monitor_states(OrbitProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  Verdict monitor_signature(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  Verdict monitor_beyond_grazing(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  Verdict end_at_half(BranchProblem& problem, const CurvePoint& before, double part, CurvePoint& after, Branch& branch);
  bool interrupted_now();
  std::optional<Verdict> end_of_range(BranchProblem& problem, const CurvePoint& before, CurvePoint& after) const;
  bool take(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, BranchPoint point,
            std::vector<MetPoint> met, Branch& branch);
  void begin(BranchProblem& problem, const Vector& u, Branch& branch);
  bool end_on_bound(BranchProblem& problem, Branch& branch);
  std::optional<GrazingEnd> finish(BranchProblem& problem, const Curve& curve, Branch& branch, bool on_grazing);
  double better_section(OrbitProblem& problem, const Vector& u) const;
  std::optional<BranchStart> to_signature(OrbitProblem& problem, const BranchStart& start) const;

  // Special points (branch_follower_points.cpp).
  std::optional<MetPoint> locate(BranchProblem& problem, const TestFunction& test, const TestPoint& before,
                                 const TestPoint& after, const Branch& branch) const;
  MetPoint locate_impact_change(OrbitProblem& problem, const CurvePoint& before, const CurvePoint& after,
                                const BranchPoint& reached, const Branch& branch) const;
  bool reaches_grazing(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  std::optional<CurvePoint> beside_grazing(SignatureProblem& problem, const Vector& grazing, const CurvePoint& point) const;
  bool take_up_to_grazing(SignatureProblem& problem, const Vector& grazing, CurvePoint& last, Branch& branch);
  std::optional<GrazingEnd> broken_off_at_grazing(OrbitProblem& problem, Branch& branch);
  SpecialPoint grazing_point(const LocatedGrazing& located, int impacts_before, int impacts_after, const Branch& branch) const;
  void user_points(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, const Branch& branch,
                   std::vector<MetPoint>& met) const;
  SpecialPoint plain_point(BranchProblem& problem, const Vector& u, PointType type, const Branch& branch) const;
  void mark(BranchProblem& problem, const Vector& u, PointType type, Branch& branch);
  Vector at_value(BranchProblem& problem, Vector u, double value) const;

  const HybridSystem& system_;
  const ContinuationOptions& options_;
  double low_, high_;
  bool hard_contacts_ = false;
  std::vector<Symmetry> symmetries_;  // where the branch begins
  // Of the branch being followed.
  Vector last_;  ///< unknowns of its last point
  bool interrupted_ = false, returned_ = false, chatter_ends_ = false;
  /// Next to the value and the place along the step where a stiff contact's grazing is a corner.
  struct Corner {
    double value, place;
    bool to_contact;
  };
  bool clear_of_soft_ = false;    ///< nodes keep clear of soft contacts too
  std::optional<Corner> corner_;  ///< set while a step goes around it
  bool section_blocked_ = false;  ///< an impact has come too close to a node
  std::optional<GrazingEnd> grazing_;
  // While a branch that starts on a grazing has no point yet:
  Vector beginning_;      ///< the grazing
  double fastest_ = 0.0;  ///< its weakest impact at its fastest
  Vector fastest_point_;
  std::optional<SignatureEquations::Violation> refused_;  ///< why the orbit tried last is no motion
};

}  // namespace graze
