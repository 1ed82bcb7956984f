// SPDX-License-Identifier: GPL-3.0-or-later
// ShootingNodes: the states of an orbit at its nodes as the unknowns of Newton's method, with a Propagator that carries them.
#pragma once

#include <graze/floquet/orbit/shooting_equations.hpp>
#include <graze/lib/tasks/newton_loop.hpp>

#include <optional>

namespace graze {

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
