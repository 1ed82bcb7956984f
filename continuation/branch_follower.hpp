// SPDX-License-Identifier: GPL-3.0-or-later
// BranchFollower: one branch of orbits from its first point to its end: the tracer's monitor that turns curve points into branch
// points, evaluates the test functions, locates what they announce, and knows the ends of the parameter's range.
#pragma once

#include <graze/continuation/continuation.hpp>
#include <graze/continuation/grazing.hpp>
#include <graze/continuation/test_functions/test_function.hpp>

namespace graze {

/// The grazing of a hard contact on which a branch has ended, for whoever goes on from there.
struct GrazingEnd {
  LocatedGrazing grazing;
  bool lost = false;  ///< the branch had the impact; otherwise the orbits beyond gain it
};

class BranchFollower {
 public:
  /// `low`, `high`: the range of the parameter. `label` gives the next label of a type.
  BranchFollower(const HybridSystem& system, const ContinuationOptions& options, double low, double high,
                 std::function<std::string(PointType)> label);

  /// Follows the branch through `u0` in the direction of `orientation`, into `branch` (id, parent, period and parameters are
  /// set).
  /// Returns the grazing on which it ended, if so.
  std::optional<GrazingEnd> follow(OrbitProblem& problem, const Vector& u0, const Vector& orientation, Branch& branch);

 private:
  Verdict monitor(OrbitProblem& problem, const CurvePoint& before, CurvePoint& after, Branch& branch);
  bool skipped_something(const TestPoint& before, const TestPoint& after) const;
  SpecialPoint locate(OrbitProblem& problem, const TestFunction& test, const TestPoint& before, const TestPoint& after,
                      const Branch& branch) const;
  void locate_impact_change(OrbitProblem& problem, const CurvePoint& before, const CurvePoint& after, const BranchPoint& reached,
                            Branch& branch);
  std::optional<GrazingEnd> broken_off_at_grazing(OrbitProblem& problem, Branch& branch);
  void add_grazing(const OrbitProblem& problem, const LocatedGrazing& located, int impacts_before, int impacts_after,
                   Branch& branch);
  void user_points(OrbitProblem& problem, const CurvePoint& before, const CurvePoint& after, Branch& branch);
  void mark_end(OrbitProblem& problem, const Vector& u, PointType type, Branch& branch);
  double better_section(OrbitProblem& problem, const Vector& u) const;
  Vector at_value(OrbitProblem& problem, Vector guess, double value) const;

  const HybridSystem& system_;
  const ContinuationOptions& options_;
  double low_, high_;
  std::function<std::string(PointType)> label_;
  bool hard_contacts_ = false;
  bool interrupted_ = false, returned_ = false;
  bool section_blocked_ = false;  ///< an impact has come too close to a node
};

}  // namespace graze
