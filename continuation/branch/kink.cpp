// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch/kink.hpp>
#include <graze/continuation/conditions/test_function.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

bool is_kink(const BranchPoint& before, const BranchPoint& after) {
  constexpr double jump = 0.1;  // relative to 1 + |mu|
  if (before.impacts != after.impacts || before.signature.events == after.signature.events) return false;
  const auto &a = before.multipliers.values, &b = after.multipliers.values;
  double farthest = 0.0, size = 1.0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const auto near = std::min_element(b.begin(), b.end(),
                                       [&](const auto& x, const auto& y) { return std::abs(x - a[i]) < std::abs(y - a[i]); });
    farthest = std::max(farthest, std::abs(*near - a[i]));
    size = std::max(size, 1.0 + std::abs(a[i]));
  }
  return farthest > jump * size;
}

bool holds_more(const OrbitProblem& problem, const Vector& u) { return problem.kept_states(u).size() > problem.pinned().size(); }

bool releases_pinned(const OrbitProblem& problem, const BranchPoint& point) {
  const int of_time = point.multipliers.section == Section::autonomous ? 1 : 0;
  return point.multipliers.trivial - of_time < std::ssize(problem.pinned());
}

void describe_kink(SpecialPoint& kink, const Branch& branch, const BranchPoint& next, bool holds, bool goes_on) {
  const auto on_edge = [](const BranchPoint& at) {
    for (const std::complex<double>& mu : nontrivial(at.multipliers))
      if (std::abs(mu - 1.0) < 1e-6) return true;
    return false;
  };
  if (holds)
    while (kink.after_point > 0 && on_edge(branch.points[kink.after_point])) --kink.after_point;
  kink.value = branch.points[kink.after_point].value;
  kink.status = PointStatus::bracketed;
  kink.precision = std::abs(next.value - kink.value);
  kink.interval[0] = std::min(next.value, kink.value);
  kink.interval[1] = std::max(next.value, kink.value);
  kink.details["kind"] = "sliding";
  kink.details["scenario"] =
      std::string(grazing_scenario_name(goes_on ? GrazingScenario::persistence : GrazingScenario::nonsmooth_fold));
}

std::optional<BeyondKink> beyond_kink(OrbitProblem& problem, const CurvePoint& last, const BranchPoint& end,
                                      const TraceOptions& options, const std::function<bool()>& cancelled) {
  constexpr double off_tangent = 0.1;  // of the way from the kink
  const ZeroProblem zero = problem.zero_problem();
  const Eigen::Index of_value = last.u.size() - 1;
  const double onwards = std::copysign(1.0, last.tangent[of_value]);
  for (const bool goes_on : {true, false})
    for (const double step : {1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3}) {
      if (cancelled()) return std::nullopt;
      CurvePoint next;
      next.u = last.u;
      next.u[of_value] += (goes_on ? onwards : -onwards) * step * problem.scale();
      if (!correct(zero, problem.parameter_direction(), next.u, options).converged()) continue;
      const Vector change = next.u - last.u;
      next.tangent = tangent_at(zero, next.u, change);
      if (next.tangent.size() == 0) continue;
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
