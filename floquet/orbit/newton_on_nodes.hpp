// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's method for the states of an orbit at its nodes: one loop for all motions, whether a Propagator carries them or SIMD
// lanes do. It is a task, which waits while other tasks' motions fill the lanes. DampedNewton decides about its steps.
#pragma once

#include <graze/floquet/orbit/shooting_equations.hpp>
#include <graze/lib/numerics/newton.hpp>
#include <graze/lib/tasks/task.hpp>

#include <coroutine>
#include <optional>

namespace graze {

/// Newton's method from u, which is changed in place. `nodes` are the equations:
///   Unknowns                          of the orbit (copyable)
///   carry(trial)                      co_await: carries the motions from the nodes
///   residual(trial)                   of these motions, relative to size(trial); nullopt: they do not reach the next nodes
///   accept()                          u is the trial carried last
///   gives_up(report)                  whether to end here; the report is then not converged, unless it was before
///   solve(u)                          length of the step -J^{-1} F at u; not finite: J is singular
///   size(u)                           1 + |u|
///   move(u, factor, trial)            trial = u + factor step
/// At the end the motions carried last need not be those of u: the last trial may have been rejected.
template <class Nodes>
MotionTask<NewtonReport> newton_on_nodes(Nodes& nodes, const DampedNewtonRule& rule, typename Nodes::Unknowns& u) {
  DampedNewton newton(rule);
  typename Nodes::Unknowns trial = u;
  while (newton.open()) {
    co_await nodes.carry(trial);
    if (newton.take(nodes.residual(trial))) {
      u = trial;
      nodes.accept();
      if (!newton.open() || nodes.gives_up(newton.report())) break;
      newton.begin_step(nodes.solve(u), nodes.size(u));
    }
    if (newton.open()) nodes.move(u, newton.factor(), trial);
  }
  co_return newton.report();
}

/// The nodes of ShootingEquations. They never wait.
class ShootingNodes {
 public:
  using Unknowns = Vector;

  explicit ShootingNodes(ShootingEquations& equations, const TransitionOptions& options = {.sensitivity = Sensitivity::state})
      : equations_(equations), options_(options) {}

  std::suspend_never carry(const Vector& trial) {
    carried_ = equations_.evaluate(trial, options_);
    return {};
  }
  std::optional<double> residual(const Vector& trial);
  void accept() {}
  bool gives_up(const NewtonReport&) const { return false; }
  double solve(const Vector& u);
  double size(const Vector& u) const { return 1.0 + u.lpNorm<Eigen::Infinity>(); }
  void move(const Vector& u, double factor, Vector& trial) const { trial = u + factor * step_; }

 private:
  ShootingEquations& equations_;
  TransitionOptions options_;
  bool carried_ = false;
  Vector residual_, step_;
  Matrix jacobian_;
};

/// The result of a task that never waits.
template <class T> T result_at_once(MotionTask<T> task) {
  task.begin();
  return task.result();
}

}  // namespace graze
