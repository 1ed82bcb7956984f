// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/branch_step.hpp>
#include <graze/continuation/branch/signature_follower.hpp>
#include <graze/continuation/conditions/grazing_by_events.hpp>
#include <graze/continuation/conditions/grazing_in_step.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

/// Detects a fold or a period doubling closer to the grazing than the branch's points: the signs of its conditions, regular in
/// the coordinates of the events, differ between the grazing and `point`. Then halves the distance to the grazing until the
/// signs are those at the grazing, and returns that point; empty if there is none.
std::optional<CurvePoint> special_point_near_grazing(SignatureProblem& problem, const Vector& grazing, const CurvePoint& point,
                                                     const TraceOptions& options) {
  const ZeroProblem zero = problem.zero_problem();
  struct Signs {
    bool turned, doubled;
    bool operator==(const Signs&) const = default;
  };
  const auto signs = [&](const Vector& u, const Vector& tangent) {
    return Signs{problem.value(tangent) < 0.0, OrbitLU<Matrix>(problem.cyclic(u, -1.0).real()).sign_of_determinant() < 0.0};
  };
  const Vector tangent = tangent_at(zero, grazing, point.tangent);
  if (tangent.size() == 0) return std::nullopt;
  const Signs there = signs(grazing, tangent);
  if (there == signs(point.u, point.tangent)) return std::nullopt;
  const Vector chord = point.u - grazing;
  for (double part = 0.5; part * weighted_norm(zero.weights, chord) > least_resolved_speed; part *= 0.5) {
    CurvePoint between;
    between.u = grazing + part * chord;
    if (!correct(zero, chord, between.u, options).converged() || problem.violation(between.u)) return std::nullopt;
    between.tangent = tangent_at(zero, between.u, point.tangent);
    if (between.tangent.size() == 0) return std::nullopt;
    if (signs(between.u, between.tangent) != there) continue;
    between.arclength = point.arclength - (1.0 - part) * weighted_norm(zero.weights, chord);
    return between;
  }
  return std::nullopt;
}

}  // namespace

SignatureFollower::SignatureFollower(const FollowSettings& settings, SignatureProblem& problem, BranchRecord& record)
    : settings_(settings), problem_(problem), record_(record) {}

Curve SignatureFollower::follow(const BranchStart& start) {
  if (start.on_grazing) beginning_ = start.u;
  ZeroProblem zero = traced_problem(settings_, problem_);
  // Events of a contact may coincide on a limit of the parameter (a damper that vanishes). States reach it from here.
  constexpr double far_enough = 1e-2;
  if (problem_.through_modes() && !start.on_grazing) zero.limits.back().shortest = far_enough;
  return trace(
      zero, start.u, start.orientation, settings_.options.trace,
      [&](const CurvePoint& before, CurvePoint& after) {
        if (record_.empty() && !start.on_grazing) record_.begin(problem_, before.u);
        return monitor(before, after);
      },
      [&](const CurvePoint& first) { return images_of(problem_, first); });
}

std::optional<Vector> SignatureFollower::fastest_point() const {
  return fastest_ >= least_resolved_speed ? std::optional(fastest_point_) : std::nullopt;
}

Verdict SignatureFollower::monitor_beyond_grazing(const CurvePoint& before, CurvePoint& after) {
  const double value = problem_.value(after.u);
  const bool outside = value < settings_.low || value > settings_.high;
  refused_ = problem_.violation(after.u);
  const bool is_motion = !outside && !refused_;
  const bool at_end = is_motion && value != problem_.value(before.u) && (value == settings_.low || value == settings_.high);
  const double speed = is_motion ? problem_.least_speed(after.u) : 0.0;
  if (speed > fastest_) {
    fastest_ = speed;
    fastest_point_ = after.u;
  }
  if (is_motion && speed >= least_kept_speed) {
    const Verdict next = at_end ? Verdict::stop : Verdict::go_on;
    const std::optional<CurvePoint> nearer = special_point_near_grazing(problem_, beginning_, after, settings_.options.trace);
    record_.begin(problem_, nearer ? nearer->u : after.u);
    if (!nearer) return next;
    BranchPoint point = problem_.branch_point(after.u, after.arclength - nearer->arclength);
    if (point.multipliers.valid && record_.take(problem_, *nearer, after, std::move(point), {})) return next;
    record_.clear();
    return {Verdict::reject, BranchRecord::special_points_lost};
  }
  if (is_motion && !at_end) return Verdict::go_on;
  const bool ends = outside || at_end;
  const Verdict too_slow(Verdict::reject, "its impact is slower than can be resolved");
  if (fastest_ < least_resolved_speed) return ends ? Verdict::stop : too_slow;
  record_.begin(problem_, fastest_point_);
  const double bound = std::clamp(value, settings_.low, settings_.high);
  if (ends)
    record_.end_with(
        {BranchStop::reached_bound, bound,
         fmt::format("the end of the range, {} = {:.12g}, was reached with an impact slower than {} all along; the orbit with "
                     "the fastest is kept",
                     record_.branch().parameter, bound, least_kept_speed)});
  if (ends || reaches_grazing(before, after)) return Verdict::stop;
  record_.clear();
  return too_slow;
}

Verdict SignatureFollower::monitor(const CurvePoint& before, CurvePoint& after) {
  if (record_.interrupted_now()) return Verdict::stop;
  if (record_.empty()) return monitor_beyond_grazing(before, after);
  const std::optional<Verdict> end = end_of_range(settings_, problem_, before, after);
  if (end == Verdict::reject) return *end;
  refused_ = problem_.violation(after.u);
  if (refused_) return reaches_grazing(before, after) ? Verdict::stop : Verdict::reject;
  BranchPoint point =
      problem_.branch_point(after.u, record_.branch().points.back().arclength + after.arclength - before.arclength);
  if (const auto verdict = record_.rejection_of(point)) return *verdict;
  if (const auto verdict = record_.end_at_half(problem_, before, after)) return *verdict;
  if (!record_.take(problem_, before, after, std::move(point), {})) return {Verdict::reject, BranchRecord::special_points_lost};
  return end.value_or(Verdict::go_on);
}

bool SignatureFollower::reaches_grazing(const CurvePoint& before, CurvePoint& after) {
  const ZeroProblem zero = problem_.zero_problem();
  const double length = after.arclength - before.arclength;
  const Vector chord = after.u - before.u;
  auto beyond = problem_.violation(after.u);
  Vector good = before.u;
  double lo = 0.0, hi = 1.0;
  // Bisects until the last motion (with impacts of at least that speed) and the first solution that is no motion are adjacent.
  const auto narrow_bracket = [&](double speed) {
    for (int i = 0; i < 40 && (hi - lo) * length > 1e-9; ++i) {
      const double middle = 0.5 * (lo + hi);
      Vector u = before.u + middle * chord;
      if (!correct(zero, chord, u, settings_.options.trace).converged()) return false;
      const auto violation = problem_.violation(u);
      if (violation) beyond = violation;
      if (violation || problem_.least_speed(u) < speed) {
        hi = middle;
      } else {
        good = u;
        lo = middle;
      }
    }
    return true;
  };
  if (!narrow_bracket(least_kept_speed)) return false;
  // An orbit about to gain an impact is kept only at this distance before the grazing, where a free run separates it from the
  // grazing.
  constexpr double least_separation = 1e-8;
  CurvePoint last = before;
  last.u = good;
  double kept = lo;
  if (!beyond->lost && lo * length > least_separation) {
    const double earlier = lo - least_separation / length;
    Vector u = before.u + earlier * chord;
    if (correct(zero, chord, u, settings_.options.trace).converged() && !problem_.violation(u)) {
      last.u = std::move(u);
      kept = earlier;
    }
  }
  last.arclength = before.arclength + kept * length;
  last.tangent = tangent_at(zero, last.u, before.tangent);
  BranchPoint point;
  if (kept > 0.0 && last.tangent.size() > 0)
    point = problem_.branch_point(last.u, record_.branch().points.back().arclength + kept * length);
  hi = 1.0;
  if (!narrow_bracket(0.0)) return false;
  // Added to the width of the bracket: the effect of rounding in a speed or a gap.
  constexpr double next_to = 1e-7;
  std::optional<GrazingAhead> ahead = grazing_ahead(problem_, good, *beyond, next_to + 4.0 * (hi - lo) * length);
  if (!ahead) return false;
  // Special points before the grazing are located in this step; the multipliers at the grazing itself are singular.
  const BranchRecord::Mark mark = record_.mark();
  if (point.multipliers.valid && !record_.take(problem_, before, last, std::move(point), {})) return false;
  if (!(kept > 0.0 && last.tangent.size() > 0)) last = before;
  if (!append_points_before_grazing(ahead->u, last)) {
    record_.roll_back(mark);
    return false;
  }
  Branch& branch = record_.branch();
  const int impacts = branch.points.back().impacts;
  branch.special_points.push_back(
      grazing_point(settings_.system, ahead->grazing, impacts, impacts + (ahead->lost ? -ahead->grazing.touches : 1), branch));
  after = std::move(last);
  grazing_ = GrazingEnd{std::move(ahead->grazing), ahead->lost};
  return true;
}

bool SignatureFollower::append_points_before_grazing(const Vector& grazing, CurvePoint& last) {
  std::optional<CurvePoint> nearer = special_point_near_grazing(problem_, grazing, last, settings_.options.trace);
  if (!nearer) return true;
  nearer->arclength = 2.0 * last.arclength - nearer->arclength;  // mirrored: here the grazing lies ahead
  BranchPoint point =
      problem_.branch_point(nearer->u, record_.branch().points.back().arclength + nearer->arclength - last.arclength);
  if (!point.multipliers.valid) return true;
  if (!record_.take(problem_, last, *nearer, std::move(point), {})) return false;
  last = std::move(*nearer);
  return true;
}

}  // namespace graze
