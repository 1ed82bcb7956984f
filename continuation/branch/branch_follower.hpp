// SPDX-License-Identifier: GPL-3.0-or-later
// BranchFollower: follows one branch from its start to its end. A monitor of the tracer watches the range, the test functions,
// the impacts and the return to a parent, and locates the special points.
//
// Orbits with hard impacts are followed in the coordinates of their signature, in which nothing is singular at a grazing. The
// branch ends at the grazing where the speed of an impact goes to zero or a flight reaches a barrier; the grazing is located.
// All other orbits (soft contacts, sticking, no impact) are followed in their states at fixed phases.
#pragma once

#include <graze/continuation/branch/branch_switching.hpp>
#include <graze/continuation/branch/continuation_options.hpp>
#include <graze/continuation/branch/points_in_step.hpp>
#include <graze/continuation/problems/signature_problem.hpp>

namespace graze {

/// Least speed of the weakest impact for which an orbit is kept as a point of a branch (dimensionless). Below it a free run no
/// longer reproduces the orbit: the instant of the impact has error (rounding of the state) / (impact speed).
inline constexpr double least_kept_speed = 1e-5;

/// Speed below which an impact cannot be distinguished from rounding (dimensionless).
inline constexpr double least_resolved_speed = 1e-10;

struct GrazingEnd {
  LocatedGrazing grazing;
  bool lost = false;  ///< the branch has the impact; otherwise the orbits beyond gain it
};

class BranchFollower {
 public:
  /// `low`, `high`: the range of the parameter.
  BranchFollower(const HybridSystem& system, const ContinuationOptions& options, double low, double high);
  BranchFollower(HybridSystem&&, const ContinuationOptions&, double, double) = delete;

  /// Follows the branch from `start` and writes it to `branch`, whose parent, period and parameters are set. Special points get
  /// no labels here. Returns the grazing on which the branch ended, if any.
  std::optional<GrazingEnd> follow(OrbitProblem& problem, const BranchStart& start, Branch& branch);

 private:
  // Following in states and in the coordinates of the signature, and the work common to both at each step.
  Curve follow_states(OrbitProblem& problem, const BranchStart& given, Branch& branch);
  Curve follow_signature(SignatureProblem& problem, const BranchStart& start, Branch& branch);
  std::optional<BranchStart> continuation_in_states(OrbitProblem& problem, const SignatureProblem& signature, const Curve& curve,
                                                    const Branch& branch) const;
  bool step_around_corner(OrbitProblem& problem, Branch& branch, CurvePoint& last);
  Vector pin_what_is_held(OrbitProblem& problem);
  bool step_over_kink(OrbitProblem& problem, Branch& branch, CurvePoint& last);
  void append_beyond_kink(OrbitProblem& problem, const Vector& u, BranchPoint point, bool goes_on, Branch& branch);
  void end_at_chatter(const Branch& branch);
  std::optional<Verdict> end_at_equilibrium(OrbitProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  Verdict monitor_states(OrbitProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  Verdict monitor_signature(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  Verdict monitor_beyond_grazing(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  Verdict end_before(BranchProblem& problem, const CurvePoint& before, double part, CurvePoint& after, Branch& branch);
  std::optional<Verdict> end_at_half(BranchProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  bool interrupted_now();
  std::optional<Verdict> end_of_range(BranchProblem& problem, const CurvePoint& before, CurvePoint& after) const;
  bool take(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, BranchPoint point,
            std::vector<PointInStep> met, Branch& branch);
  void begin(BranchProblem& problem, const Vector& u, Branch& branch);
  bool end_on_bound(BranchProblem& problem, Branch& branch);
  std::optional<GrazingEnd> finish(BranchProblem& problem, const Curve& curve, Branch& branch, bool on_grazing);
  double better_section(OrbitProblem& problem, const Vector& u) const;
  std::optional<BranchStart> to_signature(OrbitProblem& problem, const BranchStart& start) const;

  // Special points.
  bool reaches_grazing(SignatureProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  std::optional<CurvePoint> special_point_near_grazing(SignatureProblem& problem, const Vector& grazing,
                                                       const CurvePoint& point) const;
  bool append_points_before_grazing(SignatureProblem& problem, const Vector& grazing, CurvePoint& last, Branch& branch);
  std::optional<GrazingEnd> grazing_at_failure(OrbitProblem& problem, double onwards, Branch& branch);
  void mark(BranchProblem& problem, const Vector& u, PointType type, Branch& branch);

  const HybridSystem& system_;
  const ContinuationOptions& options_;
  double low_, high_;
  bool hard_contacts_ = false;
  std::vector<TestFunction> tests_;
  std::vector<Symmetry> symmetries_;  // those found at the start of the branch
  // State of the branch being followed.
  Vector last_;  ///< unknowns of its last point
  /// Values of the test functions at the point before the last one; empty: there is none.
  struct EarlierValues {
    double arclength = 0.0;
    std::vector<double> values;
  };
  EarlierValues earlier_;
  bool interrupted_ = false;
  /// The end that was met in the last step, if it is neither the end of the range nor a grazing.
  struct Ending {
    BranchStop reason;
    double value;
    std::string message;
  };
  std::optional<Ending> ending_;
  /// Corner of the branch at the grazing of a stiff contact: parameter value and place along the step.
  struct Corner {
    double value, place;
    bool to_contact;
  };
  bool clear_of_soft_ = false;    ///< nodes stay clear of soft contacts too
  std::optional<Corner> corner_;  ///< set during a step around it
  bool section_blocked_ = false;  ///< an impact is too close to a node
  bool holds_more_ = false;       ///< at the last step friction begins to hold a body all along
  std::optional<GrazingEnd> grazing_;
  // For a branch that starts on a grazing, until it has its first point:
  Vector beginning_;      ///< the grazing
  double fastest_ = 0.0;  ///< largest speed of the weakest impact so far
  Vector fastest_point_;
  std::optional<SignatureEquations::Violation> refused_;  ///< why the last trial solution is no motion
};

}  // namespace graze
