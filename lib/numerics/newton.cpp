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

}  // namespace graze
