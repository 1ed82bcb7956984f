// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's method: to the last digit from a good start (newton_to_rounding), or from afar with steps that are halved
// (DampedNewton); and the outcome of an iteration, part of every result that Newton's method computes.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <functional>
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

/// The equations F(v) = 0 at one iterate v.
struct NewtonIterate {
  double residual = 0.0;  ///< |F|, as its method scales it
  Vector step;            ///< -J^{-1} F; not finite where the Jacobian J is singular
  double length = 0.0;    ///< of the step, relative to the size of the unknowns
  bool may_be_last = true;
};

struct NewtonRule {
  int max_iterations = 20;
  double acceptance = 1e-11;                                 ///< of the residual
  double shortest = 1e-14;                                   ///< a step below this is rounding
  double longest = std::numeric_limits<double>::infinity();  ///< a longer step has left for another solution: stalled
};

/// Newton's method from v, which is changed in place. It ends where the residual is accepted and the step is rounding: shorter
/// than `shortest`, or not half as long as the one before. That step is not taken; its size estimates the error that is left.
/// `linearise` evaluates the equations at an iterate; nullopt: they cannot be evaluated there.
NewtonReport newton_to_rounding(Vector& v, const std::function<std::optional<NewtonIterate>(const Vector& v)>& linearise,
                                const NewtonRule& rule = {});

struct DampedNewtonRule {
  double tolerance = 1e-13;   ///< of the residual; below it the iteration goes on while the residual is halved
  double acceptance = 1e-12;  ///< a residual that stalls below this counts as converged
  double rounding = 0.0;      ///< a residual that cannot become smaller
  int max_iterations = 40;
  int max_halvings = 12;  ///< of a step that does not reduce the residual
  double max_step = 0.5;  ///< longest step, relative to the size of the unknowns
};

/// The rule of a Newton iteration whose steps are halved until the residual decreases. The caller evaluates the equations and
/// solves for the steps, wherever that happens:
///
///   while (newton.open()) {
///     evaluate the residual at `trial` (at first the start)
///     if (newton.take(residual)) iterate = trial, and if still open: step = -J^{-1} F, newton.begin_step(|step|, size)
///     trial = iterate + newton.factor() * step
///   }
///
/// Residuals are relative to the size of the unknowns.
class DampedNewton {
 public:
  explicit DampedNewton(const DampedNewtonRule& rule) : rule_(rule) {}

  bool open() const { return open_; }
  bool begun() const { return !report_.residual_history.empty(); }  ///< the start was evaluated
  /// Takes the residual at the trial; nullopt: it could not be evaluated. True: the trial is the new iterate.
  bool take(std::optional<double> residual);
  /// Takes the length of the full step and the size of the unknowns. A length that is not finite: the Jacobian is singular.
  void begin_step(double length, double size);
  double factor() const { return factor_; }  ///< of the full step, to the next trial
  const NewtonReport& report() const { return report_; }

 private:
  void end(NewtonStatus otherwise);
  void end_without_step();

  DampedNewtonRule rule_;
  NewtonReport report_;
  double factor_ = 1.0;
  int halvings_ = 0;
  bool open_ = true;
};

}  // namespace graze
