// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/kink.hpp>
#include <graze/continuation/conditions/test_function.hpp>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

namespace graze {

namespace {

/// The largest change of a multiplier between two orbits, relative to 1 + |mu|.
double jump_of_multipliers(const BranchPoint& before, const BranchPoint& after) {
  const auto &a = before.multipliers.values, &b = after.multipliers.values;
  double farthest = 0.0, size = 1.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const auto near = std::min_element(b.begin(), b.end(),
                                       [&](const auto& x, const auto& y) { return std::abs(x - a[i]) < std::abs(y - a[i]); });
    farthest = std::max(farthest, std::abs(*near - a[i]));
    size = std::max(size, 1.0 + std::abs(a[i]));
  }
  return farthest / size;
}

/// Whether one of the events that only one of the two orbits has is of friction or of sticking.
bool slides(const HybridSystem& system, const BranchPoint& before, const BranchPoint& after) {
  std::vector<std::size_t> a = before.signature.events, b = after.signature.events, differ;
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(differ));
  return differ.empty() || std::any_of(differ.begin(), differ.end(), [&](std::size_t i) {
           const Event& event = system.events[i];
           return event.kind == EventKind::stick || event.kind == EventKind::release ||
                  !system.modes[event.from].constraints.empty() || !system.modes[event.to].constraints.empty();
         });
}

}  // namespace

bool is_kink(const BranchPoint& before, const BranchPoint& after, double jump) {
  return before.impacts == after.impacts && before.signature.events != after.signature.events &&
         jump_of_multipliers(before, after) > jump;
}

bool holds_more(const OrbitProblem& problem, const Vector& u) { return problem.kept_states(u).size() > problem.pinned().size(); }

bool releases_pinned(const OrbitProblem& problem, const BranchPoint& point) {
  const int of_time = point.multipliers.section == Section::autonomous ? 1 : 0;
  return point.multipliers.trivial - of_time < std::ssize(problem.pinned());
}

SpecialPoint kink_between(OrbitProblem& problem, const PointBetween& before, const PointBetween& after, const Branch& branch,
                          bool goes_on) {
  SpecialPoint kink = plain_point(problem, before.curve.u, PointType::GR, branch);
  if (!kink.orbit.multipliers.valid) kink.orbit = problem.orbit(after.curve.u);  // the one before may graze
  const double a = before.branch.value, b = after.branch.value;
  kink.value = a;
  kink.status = PointStatus::bracketed;
  kink.precision = std::abs(b - a);
  kink.interval[0] = std::min(a, b);
  kink.interval[1] = std::max(a, b);
  kink.details["kind"] = std::string(slides(problem.system(), before.branch, after.branch) ? "sliding" : "contact");
  kink.details["scenario"] =
      std::string(grazing_scenario_name(goes_on ? GrazingScenario::persistence : GrazingScenario::nonsmooth_fold));
  return kink;
}

std::size_t last_before_hold(const Branch& branch) {
  const auto on_edge = [](const BranchPoint& at) {
    for (const std::complex<double>& mu : nontrivial(at.multipliers))
      if (std::abs(mu - 1.0) < 1e-6) return true;
    return false;
  };
  std::size_t last = branch.points.size() - 1;
  while (last > 0 && on_edge(branch.points[last])) --last;
  return last;
}

std::optional<PointInStep> kink_in_step(OrbitProblem& problem, const TestPoint& before, const TestPoint& after,
                                        const Branch& branch, const TraceOptions& options) {
  constexpr double narrow = 1e-8, widest = 1e-5;
  PointBetween lo{before.curve, before.branch}, hi{after.curve, after.branch};
  const auto may_be = [&] { return is_kink(lo.branch, hi.branch, least_jump); };
  while (may_be() && hi.curve.arclength - lo.curve.arclength > narrow) {
    std::optional<PointBetween> middle = point_between(problem, {lo.curve, lo.branch}, {hi.curve, hi.branch}, 0.5, options);
    if (!middle || middle->branch.impacts != lo.branch.impacts) break;
    (middle->branch.signature.events == lo.branch.signature.events ? lo : hi) = std::move(*middle);
  }
  if (!may_be() || hi.curve.arclength - lo.curve.arclength > widest) return std::nullopt;
  return PointInStep{place_of(problem.zero_problem(), before.curve, lo.curve.u), lo.curve.u,
                     kink_between(problem, lo, hi, branch, true)};
}

std::optional<BeyondKink> beyond_kink(OrbitProblem& problem, const CurvePoint& last, const BranchPoint& end,
                                      const TraceOptions& options, const std::function<bool()>& cancelled) {
  constexpr double off_tangent = 0.1;  // of the way from the kink
  const ZeroProblem zero = problem.zero_problem();
  const Eigen::Index of_value = problem.orbit_unknowns();
  const double onwards = std::copysign(1.0, last.tangent[of_value]);
  // An orbit back along the branch is also found from the branch that came here.
  const auto is_on_branch = [&](const Vector& u) {
    constexpr double same = 1e-3;  // of the way from the kink
    const double way = (u[of_value] - last.u[of_value]) / last.tangent[of_value];
    Vector back = last.u + way * last.tangent;
    if (!correct(zero, problem.parameter_direction(), back, options).converged()) return true;
    return weighted_norm(zero.weights, u - back) < same * weighted_norm(zero.weights, u - last.u);
  };
  for (const bool goes_on : {true, false})
    for (const double step : {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3}) {
      if (cancelled()) return std::nullopt;
      CurvePoint next;
      next.u = last.u;
      next.u[of_value] += (goes_on ? onwards : -onwards) * step * problem.scale();
      if (!correct(zero, problem.parameter_direction(), next.u, options).converged()) continue;
      const Vector change = next.u - last.u;
      next.tangent = tangent_at(zero, next.u, change);
      if (next.tangent.size() == 0 || (!goes_on && is_on_branch(next.u))) continue;
      const double along = change.dot(zero.weights.cwiseProduct(next.tangent)), length = weighted_norm(zero.weights, change);
      if (!(weighted_norm(zero.weights, change - along * next.tangent) < off_tangent * length)) continue;
      next.arclength = last.arclength + length;
      BranchPoint point = problem.branch_point(next.u, end.arclength + length);
      if (!point.multipliers.valid || point.signature == end.signature || point.impacts != end.impacts) continue;
      if (!releases_pinned(problem, point)) return BeyondKink{std::move(next), std::move(point), goes_on};
    }
  return std::nullopt;
}

}  // namespace graze
