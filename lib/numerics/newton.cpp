// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/numerics/newton.hpp>

namespace graze {

std::string_view newton_status_text(NewtonStatus status) {
  switch (status) {
  case NewtonStatus::not_run:
    break;
  case NewtonStatus::converged:
    return "converged";
  case NewtonStatus::iteration_limit:
    return "the largest number of iterations was reached";
  case NewtonStatus::stalled:
    return "no step along Newton's direction reduces the residual";
  case NewtonStatus::evaluation_failed:
    return "the equations could not be evaluated";
  case NewtonStatus::singular:
    return "the Jacobian is singular";
  }
  return "not run";
}

NewtonReport newton_to_rounding(Vector& v, const std::function<std::optional<NewtonIterate>(const Vector& v)>& linearise,
                                const NewtonRule& rule) {
  NewtonReport report;
  constexpr double none = std::numeric_limits<double>::infinity();
  double last_length = none;
  for (int iteration = 0; iteration < rule.max_iterations; ++iteration) {
    const std::optional<NewtonIterate> at = linearise(v);
    if (!at) {
      report.status = NewtonStatus::evaluation_failed;
      return report;
    }
    report.residual_history.push_back(at->residual);
    if (!at->step.allFinite()) {
      report.status = NewtonStatus::singular;
      return report;
    }
    const bool is_rounding = at->length < rule.shortest || at->length >= 0.5 * last_length;
    if (at->may_be_last && at->residual < rule.acceptance && is_rounding) {
      report.status = NewtonStatus::converged;
      return report;
    }
    if (at->length > rule.longest) {
      report.status = NewtonStatus::stalled;
      return report;
    }
    last_length = at->may_be_last ? at->length : none;
    v += at->step;
  }
  report.status = NewtonStatus::iteration_limit;
  return report;
}

}  // namespace graze
