// SPDX-License-Identifier: GPL-3.0-or-later
// BranchRecord: the points and special points of the branch that is being followed. It appends the end of each step, with the
// special points of the step located by the test functions, and ends the branch at the end of the range or where its orbits end.
// The two ways to follow a branch (StatesFollower, SignatureFollower) write to the same record.
#pragma once

#include <graze/continuation/branch/continuation_options.hpp>
#include <graze/continuation/branch/points_in_step.hpp>
#include <graze/continuation/conditions/grazing_edge.hpp>
#include <graze/continuation/problems/branch_problem.hpp>
#include <graze/lib/system/symmetry.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace graze {

/// The setting in which branches are followed.
struct FollowSettings {
  SharedSystem system;
  ContinuationOptions options;
  double low, high;  ///< range of the parameter
  bool hard_contacts;
  std::vector<TestFunction> tests;

  FollowSettings(const SharedSystem& of, const ContinuationOptions& with, double from, double to);
};

/// The end of a branch that is neither the end of the range nor a grazing.
struct BranchEnding {
  BranchStop reason;
  double value;
  std::string message;
};

/// Corner of the branch at the grazing of a stiff contact: parameter value and place along the step.
struct Corner {
  double value, place;
  bool to_contact;
};

class BranchRecord {
 public:
  /// Why take() may return false.
  static constexpr const char* special_points_lost = "a special point there cannot be located";

  /// Refers to its arguments.
  BranchRecord(const FollowSettings& settings, Branch& branch);

  Branch& branch() const { return branch_; }
  bool empty() const { return branch_.points.empty(); }
  /// Unknowns of the last point.
  const Vector& last() const { return last_; }
  /// Rejects a point without multipliers, and one off the branch (leaves_branch()). Empty: neither.
  std::optional<Verdict> rejection_of(const BranchPoint& next) const;

  /// Appends the first point, which is an end of the branch.
  void begin(BranchProblem& problem, const Vector& u);
  /// Locates the special points between the last point and the next, and appends the next point. False if the step must be
  /// halved: it passes special points that are not located. `met`: special points that are already located in the step. `corner`:
  /// in a step around it.
  bool take(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, BranchPoint point,
            std::vector<PointInStep> met, const std::optional<Corner>& corner = {});
  /// Appends the next point of a branch whose test functions are not continuous in the step.
  void append_apart(const Vector& u, BranchPoint point);
  /// The last point in other unknowns.
  void set_last(const Vector& u) { last_ = u; }
  /// Makes the last step onto the end of the range: if the model allows no value beyond it, no step leads across it.
  bool end_on_bound(BranchProblem& problem);
  /// Adds a special point that needs no location.
  void mark(BranchProblem& problem, const Vector& u, PointType type);
  /// A state of the record, to which it can be rolled back.
  struct Mark;
  Mark mark() const;
  void roll_back(const Mark& mark);
  /// Removes all points: the branch begins again.
  void clear();

  /// Asks whether the computation is cancelled. If it was once, it stays so.
  bool interrupted_now();
  bool interrupted() const { return interrupted_; }

  /// Ends the branch just before a place in the step where its orbits end, and locates the special points up to there.
  Verdict end_before(BranchProblem& problem, const CurvePoint& before, double part, CurvePoint& after);
  /// Ends a doubled branch if it passes through the orbit of half its period in the step. Empty: it does not.
  std::optional<Verdict> end_at_half(BranchProblem& problem, const CurvePoint& before, CurvePoint& after);
  void end_with(BranchEnding ending) { ending_ = std::move(ending); }
  const std::optional<BranchEnding>& ending() const { return ending_; }

 private:
  /// Values of the test functions at the point before the last one; empty: there is none.
  struct EarlierValues {
    double arclength = 0.0;
    std::vector<double> values;
  };

  const FollowSettings& settings_;
  const std::vector<Symmetry> symmetries_;  // of the flight at the branch's parameters
  Branch& branch_;
  Vector last_;  // unknowns of the last point
  EarlierValues earlier_;
  std::optional<BranchEnding> ending_;  // met in the last step
  bool interrupted_ = false;
};

struct BranchRecord::Mark {
  std::size_t points = 0, special_points = 0;
  Vector last = {};
  EarlierValues earlier = {};
  std::optional<BranchEnding> ending = {};
};

/// The equations for the tracer: a step that would pass a limit of the parameter ends on the end of the range.
ZeroProblem traced_problem(const FollowSettings& settings, BranchProblem& problem);

/// Handles the end of the range: moves the end of the step onto it. Empty if the step does not reach it. A step that begins on
/// the end of the range and ends outside has passed a fold and must be shortened.
std::optional<Verdict> end_of_range(const FollowSettings& settings, BranchProblem& problem, const CurvePoint& before,
                                    CurvePoint& after);

}  // namespace graze
