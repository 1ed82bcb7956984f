// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/points_in_step.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace graze {

double place_of(const ZeroProblem& zero, const CurvePoint& before, const Vector& u) {
  return zero.weights.cwiseProduct(before.tangent).dot(u - before.u);
}

Vector at_value(BranchProblem& problem, Vector u, double value, const TraceOptions& options) {
  u[problem.orbit_unknowns()] = value;
  const NewtonReport report = correct(problem.zero_problem(), problem.parameter_direction(), u, options);
  if (!report.converged()) return {};
  u[problem.orbit_unknowns()] = value;
  return u;
}

SpecialPoint plain_point(BranchProblem& problem, const Vector& u, PointType type, const Branch& branch) {
  SpecialPoint point;
  point.type = type;
  point.orbit = problem.orbit(u);
  point.value = point.interval[0] = point.interval[1] = problem.value(u);
  point.status = type == PointType::MX ? PointStatus::bracketed : PointStatus::converged;
  point.after_point = branch.points.empty() ? 0 : branch.points.size() - 1;
  return point;
}

bool in_rounding(const TestFunction& test, const TestPoint& a, const TestPoint& b) {
  constexpr double rounding = 1e-8, root = 1e-5;
  const double farthest = std::max(test.distance(a.branch), test.distance(b.branch));
  const auto coincide = [](const BranchPoint& point) {
    const auto values = nontrivial(point.multipliers);
    return values.size() > 1 && std::abs(values[0] - values[1]) < 4.0 * root;
  };
  return farthest < (coincide(a.branch) && coincide(b.branch) ? root : rounding);
}

std::optional<PointBetween> point_between(BranchProblem& problem, const TestPoint& before, const TestPoint& after, double part,
                                          const TraceOptions& options) {
  const ZeroProblem zero = problem.zero_problem();
  PointBetween point;
  CurvePoint& curve = point.curve;
  curve.u = before.curve.u + part * (after.curve.u - before.curve.u);
  if (!correct(zero, after.curve.u - before.curve.u, curve.u, options).converged()) return std::nullopt;
  curve.tangent = tangent_at(zero, curve.u, before.curve.tangent);
  if (curve.tangent.size() == 0) return std::nullopt;
  curve.arclength = before.curve.arclength + part * (after.curve.arclength - before.curve.arclength);
  point.branch = problem.branch_point(curve.u, curve.arclength);
  if (!point.branch.multipliers.valid) return std::nullopt;
  return point;
}

namespace {

/// Empty if the sign changes without a special point of this type.
std::optional<PointInStep> locate_confirmed(BranchProblem& problem, const TestFunction& test, const TestPoint& before,
                                            const TestPoint& after, bool at_corner, const Branch& branch,
                                            const TraceOptions& options) {
  /// Largest distance of a multiplier from its critical value at a sign change that Newton's method did not confirm.
  constexpr double announced = 1e-3;
  const ZeroProblem zero = problem.zero_problem();
  const double length = after.curve.arclength - before.curve.arclength;
  double lo = 0.0, hi = 1.0, f_lo = test.value(before), f_hi = test.value(after);
  double value_lo = problem.value(before.curve.u), value_hi = problem.value(after.curve.u);
  CurvePoint best = after.curve;
  BranchPoint best_branch = after.branch;
  int side = 0;
  // Narrows the bracket of the sign change along the curve (Illinois method).
  const auto narrow_bracket = [&](int steps, double small, double narrow) {
    for (int i = 0; i < steps && hi - lo > narrow; ++i) {
      const double s = std::clamp((lo * f_hi - hi * f_lo) / (f_hi - f_lo), lo + 0.01 * (hi - lo), hi - 0.01 * (hi - lo));
      std::optional<PointBetween> trial = point_between(problem, before, after, s, options);
      if (!trial) break;
      const double f = test.value({trial->curve, trial->branch, problem.unit()});
      best = std::move(trial->curve);
      best_branch = std::move(trial->branch);
      if ((f < 0.0) == (f_lo < 0.0)) {
        lo = s;
        f_lo = f;
        value_lo = best_branch.value;
        if (side == 1) f_hi *= 0.5;
        side = 1;
      } else {
        hi = s;
        f_hi = f;
        value_hi = best_branch.value;
        if (side == -1) f_lo *= 0.5;
        side = -1;
      }
      if (std::abs(f) < small) break;
    }
  };
  SpecialPoint point;
  point.type = test.type;
  if (!test.condition.empty()) point.details["condition"] = test.condition;
  point.after_point = branch.points.size() - 1;
  // Newton's result must stay within the bracket of the sign change: outside lies another point of the same type. Beside such a
  // point the test function is small all over the step, and only a narrow bracket leads to the right one.
  const Vector weighted_chord = zero.weights.cwiseProduct(after.curve.u - before.curve.u);
  const auto within_bracket = [&](const Vector& u) {
    constexpr double slack = 1e-6;
    const double part = weighted_chord.dot(u - before.curve.u) / weighted_chord.dot(after.curve.u - before.curve.u);
    return weighted_norm(zero.weights, u - best.u) <= length && part >= lo - slack && part <= hi + slack;
  };
  LocatedPoint located;
  bool found = false;
  for (const bool again : {false, true}) {
    if (found) break;
    again ? narrow_bracket(40, 0.0, 1e-4) : narrow_bracket(8, 1e-5, 1e-7);
    located = locate(problem, *test.equations({best, best_branch, problem.unit()}), best.u);
    found = located.newton.converged() && within_bracket(located.u);
  }
  point.newton = located.newton;
  if (found) {
    point.status = PointStatus::converged;
    point.precision = std::max(located.precision, 4e-16 * std::abs(problem.value(located.u)));
    point.value = problem.value(located.u);
    point.orbit = problem.orbit(located.u, located.newton);
    point.orbit.multipliers = problem.branch_point(located.u, 0.0).multipliers;
    best.u = located.u;
    if (test.describe) test.describe(problem, located, point);
  } else {
    // If Newton's method fails, as at the corner of a stiff contact, the sign change along the curve is bracketed down to
    // rounding. A sign change without a multiplier at its critical value belongs to another event, or to a jump.
    narrow_bracket(60, 0.0, 1e-12);
    if (!at_corner && !(test.distance(best_branch) < announced)) return std::nullopt;
    point.value = problem.value(best.u);
    point.precision = std::max(std::abs(value_hi - value_lo), 1e-13 * problem.size_of_value(point.value));
    point.status = hi - lo <= 1e-10 ? PointStatus::converged : PointStatus::bracketed;
    point.orbit = problem.orbit(best.u);
    point.orbit.multipliers = best_branch.multipliers;
    point.details["method"] = std::string("sign change along the branch");
  }
  point.interval[0] = point.value - point.precision;
  point.interval[1] = point.value + point.precision;
  return PointInStep{place_of(zero, before.curve, best.u), best.u, std::move(point)};
}

/// Halves the step until its ends are near enough to confirm the point, then locates it.
std::optional<PointInStep> locate_halving(BranchProblem& problem, const TestFunction& test, const TestPoint& before,
                                          const TestPoint& after, bool at_corner, const Branch& branch,
                                          const TraceOptions& options) {
  constexpr int halvings = 20;
  PointBetween lo{before.curve, before.branch}, hi{after.curve, after.branch};
  const auto input = [&](const PointBetween& point) { return TestPoint{point.curve, point.branch, problem.unit()}; };
  const bool below = test.value(before) < 0.0;
  for (int i = 0; i < halvings && test.too_far_apart(input(lo), input(hi)); ++i) {
    std::optional<PointBetween> middle = point_between(problem, input(lo), input(hi), 0.5, options);
    if (!middle) return std::nullopt;
    PointBetween& end = (test.value(input(*middle)) < 0.0) == below ? lo : hi;
    end = std::move(*middle);
  }
  if (!test.confirm(input(lo), input(hi))) return std::nullopt;
  std::optional<PointInStep> met = locate_confirmed(problem, test, input(lo), input(hi), at_corner, branch, options);
  if (met) met->place = place_of(problem.zero_problem(), before.curve, met->u);
  return met;
}

}  // namespace

std::optional<PointInStep> locate_in_step(BranchProblem& problem, const TestFunction& test, const TestPoint& before,
                                          const TestPoint& after, SignChange change, const Branch& branch,
                                          const TraceOptions& options) {
  return (change.halve ? locate_halving : locate_confirmed)(problem, test, before, after, change.at_corner, branch, options);
}

void add_user_points(BranchProblem& problem, const CurvePoint& before, const CurvePoint& after, const std::vector<double>& values,
                     const TraceOptions& options, const Branch& branch, std::vector<PointInStep>& met) {
  if (values.empty()) return;
  // If the branch turns within the step, a value may be passed on both sides of the fold.
  std::vector<Vector> course{before.u};
  for (const PointInStep& point : met)
    if (point.point.type == PointType::LP && point.point.status == PointStatus::converged) course.push_back(point.u);
  course.push_back(after.u);
  for (std::size_t k = 0; k + 1 < course.size(); ++k) {
    const double a = problem.value(course[k]), b = problem.value(course[k + 1]);
    for (const double value : values) {
      if ((a < value) == (b < value)) continue;
      // Near a fold the state varies with the square root of the distance in the parameter.
      const double way = (value - a) / (b - a);
      const double part = k > 0 ? std::sqrt(way) : k + 2 < course.size() ? 1.0 - std::sqrt(1.0 - way) : way;
      const Vector u = at_value(problem, course[k] + part * (course[k + 1] - course[k]), value, options);
      if (u.size() > 0)
        met.push_back({place_of(problem.zero_problem(), before, u), u, plain_point(problem, u, PointType::UZ, branch)});
    }
  }
}

}  // namespace graze
