// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/problems/branch_problem.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

std::string_view branch_stop_name(BranchStop reason) {
  switch (reason) {
  case BranchStop::not_run:
    break;
  case BranchStop::reached_bound:
    return "reached_bound";
  case BranchStop::parameter_range:
    return "parameter_range";
  case BranchStop::point_limit:
    return "point_limit";
  case BranchStop::grazing:
    return "grazing";
  case BranchStop::step_too_small:
    return "step_too_small";
  case BranchStop::chatter:
    return "chatter";
  case BranchStop::returned:
    return "returned";
  case BranchStop::equilibrium:
    return "equilibrium";
  case BranchStop::start_failed:
    return "start_failed";
  case BranchStop::interrupted:
    return "interrupted";
  }
  return "not_run";
}

std::vector<std::vector<std::size_t>> curves_of(const std::vector<Branch>& branches) {
  const auto from_seed = [](const Branch& branch) { return !branch.parent && !branch.points.empty(); };
  // Both branches corrected the same start orbit; the results may differ by rounding.
  const auto same_start = [](const Branch& a, const Branch& b) {
    const BranchPoint &start = a.points.front(), &other = b.points.front();
    const double size = parameter_unit(a.points.back().value, start.value) + std::abs(start.value);
    return a.period == b.period && std::abs(start.value - other.value) < 1e-12 * size &&
           (start.state() - other.state()).lpNorm<Eigen::Infinity>() < 1e-10 * (1.0 + start.state().lpNorm<Eigen::Infinity>());
  };
  std::vector<std::vector<std::size_t>> curves;
  for (std::size_t k = 0; k < branches.size(); ++k) {
    const auto half = std::find_if(curves.begin(), curves.end(), [&](const std::vector<std::size_t>& curve) {
      return curve.size() == 1 && from_seed(branches[curve.front()]) && from_seed(branches[k]) &&
             same_start(branches[curve.front()], branches[k]);
    });
    if (half != curves.end()) {
      half->push_back(k);
    } else {
      curves.push_back({k});
    }
  }
  return curves;
}

}  // namespace graze
