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

/// Ends the iteration: converged if the residual is accepted.
void DampedNewton::end(NewtonStatus otherwise) {
  report_.status = begun() && report_.residual() <= rule_.acceptance ? NewtonStatus::converged : otherwise;
  open_ = false;
}

void DampedNewton::end_without_step() {
  report_.residual_history.push_back(report_.residual());
  end(NewtonStatus::stalled);
}

bool DampedNewton::take(std::optional<double> residual) {
  if (!begun()) {
    if (residual && std::isfinite(*residual))
      report_.residual_history.push_back(*residual);
    else
      end(NewtonStatus::evaluation_failed);
    return begun();
  }
  const double before = report_.residual();
  if (!residual || !(*residual < before)) {
    const bool at_rounding = residual && before <= rule_.acceptance;  // halving gains nothing
    factor_ *= 0.5;
    if (at_rounding || ++halvings_ > rule_.max_halvings) end_without_step();
    return false;
  }
  report_.residual_history.push_back(*residual);
  if (*residual <= rule_.rounding || (*residual <= rule_.tolerance && *residual > 0.5 * before))
    end(NewtonStatus::stalled);
  else if (report_.iterations() >= rule_.max_iterations)
    end(NewtonStatus::iteration_limit);
  return true;
}

void DampedNewton::begin_step(double length, double size) {
  // A step that is so long compared with the residual shows a Jacobian that is singular up to rounding: the solution is one of a
  // family, and the step leads along it.
  constexpr double rounding = 1e-13;  // of the Jacobian's smallest singular value
  const double residual = report_.residual();
  if (!std::isfinite(length)) return end(NewtonStatus::singular);
  if (residual <= rule_.acceptance && residual < rounding * (length / size)) return end(NewtonStatus::stalled);
  // A step much longer than the unknowns comes from a nearly singular Jacobian and is useless; only its direction is kept.
  const double longest = rule_.max_step * size;
  factor_ = length > longest ? longest / length : 1.0;
  halvings_ = 0;
}

}  // namespace graze
