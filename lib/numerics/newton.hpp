// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's method: the rule by which its steps are taken, halved and ended (NewtonIteration), for the loop that evaluates the
// equations (newton_loop.hpp); and the outcome, part of every result that Newton's method computes.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <limits>
#include <optional>
#include <string_view>
#include <vector>

namespace graze {

enum class NewtonStatus { not_run, converged, iteration_limit, stalled, evaluation_failed, singular };

std::string_view newton_status_text(NewtonStatus status);

struct NewtonReport {
  NewtonStatus status = NewtonStatus::not_run;
  std::vector<double> residual_history;  ///< largest residual before each step and after the last, as its method scales it
  bool converged() const { return status == NewtonStatus::converged; }
  int iterations() const { return residual_history.empty() ? 0 : static_cast<int>(residual_history.size()) - 1; }
  double residual() const { return residual_history.empty() ? -1.0 : residual_history.back(); }
};

/// When Newton's method takes a step, and when it ends. The residual is |F|, relative to the size of what the equations compare.
struct NewtonRule {
  int max_iterations = 40;
  double acceptance = 1e-12;  ///< of the residual: above it the iteration has not converged

  // Ends by the residual, unless the step decides.
  double tolerance = 1e-13;  ///< below it the iteration goes on while the residual is halved
  double rounding = 0.0;     ///< a residual that need not become smaller

  /// If given, the step decides: the iteration ends where the residual is accepted and the step is rounding, shorter than this or
  /// not half as long as the one before. That step is not taken; its size estimates the error that is left.
  std::optional<double> step_rounding = {};

  /// The solution must be isolated. Then the iteration does not converge where the Jacobian is singular or a step is refused, and
  /// no step to an accepted residual is refused. Otherwise a solution of a family is enough: there an accepted residual decides.
  bool isolated = false;

  double growth = 1.0;    ///< a step is refused if it multiplies the residual by this or more; infinite: none is
  int max_halvings = 12;  ///< of a step that is refused
  // Of a step, relative to the size of the unknowns.
  double max_step = 0.5;                                     ///< a longer one is shortened
  double longest = std::numeric_limits<double>::infinity();  ///< a longer one has left for another solution: stalled
};

/// Full steps to the last digit, from a good start: their rounding decides.
inline NewtonRule newton_to_rounding(double acceptance = 1e-11, double step_rounding = 1e-14) {
  constexpr double none = std::numeric_limits<double>::infinity();
  return {.max_iterations = 20,
          .acceptance = acceptance,
          .step_rounding = step_rounding,
          .isolated = true,
          .growth = none,
          .max_halvings = 0,
          .max_step = none};
}

/// The full step -J^{-1} F at an iterate.
struct NewtonStep {
  double length = 0.0;  ///< not finite where the Jacobian J is singular
  double size = 1.0;    ///< of the unknowns, to which the length is relative
  bool may_be_last = true;
};

/// The rule at work. The caller evaluates the equations and solves for the steps, wherever that happens:
///
///   while (newton.open()) {
///     evaluate the residual at `trial` (at first the start)
///     if (newton.take(residual)) iterate = trial, and if still open: step = -J^{-1} F, newton.begin_step(its length and size)
///     trial = iterate + newton.factor() * step
///   }
class NewtonIteration {
 public:
  explicit NewtonIteration(const NewtonRule& rule) : rule_(rule) {}

  bool open() const { return open_; }
  bool begun() const { return !report_.residual_history.empty(); }  ///< the start was evaluated
  /// Takes the residual at the trial; nullopt: it could not be evaluated. True: the trial is the new iterate.
  bool take(std::optional<double> residual);
  /// Takes the full step from the iterate. The iteration may end before it.
  void begin_step(const NewtonStep& step);
  double factor() const { return factor_; }  ///< of the full step, to the next trial
  const NewtonReport& report() const { return report_; }

 private:
  void end_as(NewtonStatus status) {
    report_.status = status;
    open_ = false;
  }
  void end(NewtonStatus otherwise);
  void end_without_step(NewtonStatus otherwise);
  bool ends_before(const NewtonStep& step);

  NewtonRule rule_;
  NewtonReport report_;
  double factor_ = 1.0;
  int halvings_ = 0;
  /// Of the step before, relative, if it might have been the last.
  double last_length_ = std::numeric_limits<double>::infinity();
  bool open_ = true;
};

}  // namespace graze
