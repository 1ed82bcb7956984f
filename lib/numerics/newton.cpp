// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/numerics/newton.hpp>

#include <cmath>

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

/// Ends the iteration. It has converged if the residual is accepted, unless the step decides.
void NewtonIteration::end(NewtonStatus otherwise) {
  const bool accepted = begun() && !rule_.step_rounding && report_.residual() <= rule_.acceptance;
  end_as(accepted ? NewtonStatus::converged : otherwise);
}

/// Ends the iteration because no step from the iterate can be taken.
void NewtonIteration::end_without_step(NewtonStatus otherwise) {
  report_.residual_history.push_back(report_.residual());
  rule_.isolated ? end_as(otherwise) : end(otherwise);
}

bool NewtonIteration::take(std::optional<double> residual) {
  if (!begun()) {
    if (residual && std::isfinite(*residual))
      report_.residual_history.push_back(*residual);
    else
      end(NewtonStatus::evaluation_failed);
    return begun();
  }
  const double before = report_.residual();
  const bool may_grow = std::isinf(rule_.growth) || (rule_.isolated && residual && *residual <= rule_.acceptance);
  if (!residual || !(may_grow || *residual < rule_.growth * before)) {
    const bool at_rounding = residual && before <= rule_.acceptance;  // halving gains nothing
    factor_ *= 0.5;
    if (at_rounding || ++halvings_ > rule_.max_halvings) {
      const bool only_trial = halvings_ == 1;
      end_without_step(!residual && only_trial ? NewtonStatus::evaluation_failed : NewtonStatus::stalled);
    }
    return false;
  }
  report_.residual_history.push_back(*residual);
  const bool is_small = *residual <= rule_.rounding || (*residual <= rule_.tolerance && *residual > 0.5 * before);
  if (is_small && !rule_.step_rounding)
    end(NewtonStatus::stalled);
  else if (report_.iterations() >= rule_.max_iterations)
    end(NewtonStatus::iteration_limit);
  return true;
}

/// Whether the iteration ends here because of the step, which is not taken.
bool NewtonIteration::ends_before(const NewtonStep& step) {
  const double residual = report_.residual(), length = step.length / step.size;
  if (!rule_.isolated && residual <= rule_.acceptance) {
    // A step that is so long compared with the residual shows a Jacobian that is singular up to rounding: the solution is one of
    // a family, and the step leads along it.
    constexpr double rounding = 1e-13;  // of the Jacobian's smallest singular value
    if (!std::isfinite(length) || residual < rounding * length) return true;
  }
  if (!rule_.step_rounding || !std::isfinite(length)) return false;
  const bool is_rounding = length < *rule_.step_rounding || length >= 0.5 * last_length_;
  last_length_ = step.may_be_last ? length : std::numeric_limits<double>::infinity();
  return step.may_be_last && residual < rule_.acceptance && is_rounding;
}

void NewtonIteration::begin_step(const NewtonStep& step) {
  if (ends_before(step)) return end_as(NewtonStatus::converged);
  if (!std::isfinite(step.length)) return end_as(NewtonStatus::singular);
  if (step.length > rule_.longest * step.size) return end_as(NewtonStatus::stalled);
  // A step much longer than the unknowns comes from a nearly singular Jacobian and is useless; only its direction is kept.
  const double longest = rule_.max_step * step.size;
  factor_ = step.length > longest ? longest / step.length : 1.0;
  halvings_ = 0;
}

}  // namespace graze
