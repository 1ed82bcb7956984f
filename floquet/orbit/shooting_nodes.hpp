// SPDX-License-Identifier: GPL-3.0-or-later
// ShootingNodes: the states of an orbit at its nodes as the unknowns of Newton's method, with a Propagator that carries them.
#pragma once

#include <graze/floquet/orbit/shooting_equations.hpp>
#include <graze/lib/tasks/newton_loop.hpp>

#include <optional>
#include <span>

namespace graze {

/// First-order map of the stretch from one node to the next, and Transition::lost.
struct NodeMap {
  const Matrix* Phi;
  int lost;
};

/// Newton's step on the nodes, -J^{-1} F; not finite where J is singular. States that constraints keep on all stretches (their
/// closing equation is no condition) stay where they are as far as possible: it is then the shortest step.
Vector step_on_nodes(const Matrix& jacobian, const Vector& residual, std::span<const NodeMap> maps);

/// ShootingEquations for newton_loop. Their residual is relative to 1 + |u|.
class ShootingNodes : public EquationsAtOnce {
 public:
  explicit ShootingNodes(ShootingEquations& equations, const TransitionOptions& options = {.sensitivity = Sensitivity::state})
      : equations_(equations), options_(options) {}

  std::optional<double> residual(const Vector& trial);
  NewtonStep solve(const Vector& u);

 private:
  ShootingEquations& equations_;
  TransitionOptions options_;
  Vector residual_;
  Matrix jacobian_;
};

}  // namespace graze
