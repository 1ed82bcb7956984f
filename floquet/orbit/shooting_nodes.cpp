// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/orbit/kept_state.hpp>
#include <graze/floquet/orbit/shooting_nodes.hpp>
#include <graze/lib/numerics/decompositions.hpp>
#include <graze/lib/numerics/orbit_lu.hpp>

#include <cmath>
#include <vector>

namespace graze {

namespace {

/// The states kept on all stretches (their closing equation is no condition), while constraints hold.
std::vector<KeptState> kept_states(const ShootingEquations& equations) {
  for (int j = 0; j < equations.nodes(); ++j)
    if (equations.stretch(j).lost == 0) return {};
  return find_kept_states(equations.states(), [&](const KeptState& one) {
    for (int j = 0; j < equations.nodes(); ++j)
      if (!one.kept_by(equations.stretch(j).Phi)) return false;
    return true;
  });
}

/// Newton's step. If states are kept, it is the shortest one: they stay where they are as far as possible.
Vector newton_step(const ShootingEquations& equations, const Matrix& jacobian, const Vector& residual) {
  if (kept_states(equations).empty()) return OrbitLU<Matrix>(jacobian).solve(-residual);
  return shortest_solution(jacobian, -residual, 1e-11);  // above the rounding of the kept rows
}

}  // namespace

std::optional<double> ShootingNodes::residual(const Vector& trial) {
  if (!equations_.evaluate(trial, options_)) return std::nullopt;
  equations_.residual(trial, residual_);
  return residual_.lpNorm<Eigen::Infinity>() / (1.0 + trial.lpNorm<Eigen::Infinity>());
}

NewtonStep ShootingNodes::solve(const Vector& u) {
  equations_.jacobian(jacobian_);
  step_ = newton_step(equations_, jacobian_, residual_);
  const double length = step_.allFinite() ? step_.lpNorm<Eigen::Infinity>() : std::nan("");
  return {.length = length, .size = 1.0 + u.lpNorm<Eigen::Infinity>()};
}

}  // namespace graze
