// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/continuation/branch.hpp>

namespace graze {

std::string_view branch_stop_name(BranchStop reason) {
  switch (reason) {
  case BranchStop::not_run:
    break;
  case BranchStop::reached_bound:
    return "reached_bound";
  case BranchStop::parameter_range:
    return "parameter_range";
  case BranchStop::point_limit:
    return "point_limit";
  case BranchStop::grazing:
    return "grazing";
  case BranchStop::step_too_small:
    return "step_too_small";
  case BranchStop::returned:
    return "returned";
  case BranchStop::start_failed:
    return "start_failed";
  case BranchStop::interrupted:
    return "interrupted";
  }
  return "not_run";
}

}  // namespace graze
