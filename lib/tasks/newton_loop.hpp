// SPDX-License-Identifier: GPL-3.0-or-later
// The loop of Newton's method: one for all equations, whether the iterates are evaluated at once or in a task, which waits while
// other tasks' motions fill the lanes. NewtonIteration decides about its steps.
#pragma once

#include <graze/lib/numerics/newton.hpp>
#include <graze/lib/tasks/task.hpp>

#include <functional>
#include <optional>

namespace graze {

/// Newton's method from u, which is changed in place. The equations have:
///   Unknowns                          (copyable)
///   evaluate(trial)                   co_await: evaluates what the residual needs, for example carries motions
///   residual(trial)                   of what was evaluated, as the rule measures it; nullopt: it could not be evaluated
///   accept()                          u is the trial evaluated last
///   gives_up(report)                  whether to end here; the report is then not converged, unless it was before
///   solve(u)                          the NewtonStep -J^{-1} F at u
///   move(u, factor, trial)            trial = u + factor step
/// At the end what was evaluated last need not belong to u: the last trial may have been rejected.
template <class Equations>
MotionTask<NewtonReport> newton_loop(Equations& equations, const NewtonRule& rule, typename Equations::Unknowns& u) {
  NewtonIteration newton(rule);
  typename Equations::Unknowns trial = u;
  while (newton.open()) {
    co_await equations.evaluate(trial);
    if (newton.take(equations.residual(trial))) {
      u = trial;
      equations.accept();
      if (!newton.open() || equations.gives_up(newton.report())) break;
      newton.begin_step(equations.solve(u));
    }
    if (newton.open()) equations.move(u, newton.factor(), trial);
  }
  co_return newton.report();
}

/// The result of a task that never waits.
template <class T> T result_at_once(MotionTask<T> task) {
  task.begin();
  return task.result();
}

/// What equations in a Vector have in common that never wait.
class EquationsAtOnce {
 public:
  using Unknowns = Vector;

  std::suspend_never evaluate(const Vector&) const { return {}; }
  void accept() const {}
  bool gives_up(const NewtonReport&) const { return false; }
  void move(const Vector& u, double factor, Vector& trial) const { trial = u + factor * step_; }

 protected:
  Vector step_;
};

/// Newton's method from u, which is changed in place, on equations that are evaluated at once. `residual` is called at each
/// trial; `solve` at the last trial that was taken, and writes the step there, which is not finite where J is singular.
NewtonReport newton(Vector& u, const std::function<std::optional<double>(const Vector& trial)>& residual,
                    const std::function<NewtonStep(const Vector& u, Vector& step)>& solve, const NewtonRule& rule);

}  // namespace graze
