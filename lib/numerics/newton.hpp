// SPDX-License-Identifier: GPL-3.0-or-later
// Outcome of a Newton iteration: part of every result that Newton's method computes.
#pragma once

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

}  // namespace graze
