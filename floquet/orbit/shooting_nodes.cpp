// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/kept_state.hpp>
#include <graze/floquet/orbit/shooting_nodes.hpp>
#include <graze/lib/numerics/decompositions.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>

#include <algorithm>
#include <cmath>
#include <vector>

namespace graze {

Vector step_on_nodes(const Matrix& jacobian, const Vector& residual, std::span<const NodeMap> maps) {
  const bool constrained = std::all_of(maps.begin(), maps.end(), [](const NodeMap& map) { return map.lost > 0; });
  const auto kept_on_all = [&](const KeptState& one) {
    return std::all_of(maps.begin(), maps.end(), [&](const NodeMap& map) { return one.kept_by(*map.Phi); });
  };
  if (!constrained || find_kept_states(maps.front().Phi->rows(), kept_on_all).empty())
    return OrbitLU<Matrix>(jacobian).solve(-residual);
  return shortest_solution(jacobian, -residual, 1e-11);  // above the rounding of the kept rows
}

std::optional<double> ShootingNodes::residual(const Vector& trial) {
  if (!equations_.evaluate(trial, options_)) return std::nullopt;
  equations_.residual(trial, residual_);
  return residual_.lpNorm<Eigen::Infinity>() / (1.0 + trial.lpNorm<Eigen::Infinity>());
}

NewtonStep ShootingNodes::solve(const Vector& u) {
  equations_.jacobian(jacobian_);
  std::vector<NodeMap> maps;
  for (int j = 0; j < equations_.nodes(); ++j) maps.push_back({&equations_.stretch(j).Phi, equations_.stretch(j).lost});
  step_ = step_on_nodes(jacobian_, residual_, maps);
  const double length = step_.allFinite() ? step_.lpNorm<Eigen::Infinity>() : std::nan("");
  return {.length = length, .size = 1.0 + u.lpNorm<Eigen::Infinity>()};
}

}  // namespace graze
