// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's method to the last digit, and the outcome of a Newton iteration: part of every result that Newton's method computes.
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

}  // namespace graze
