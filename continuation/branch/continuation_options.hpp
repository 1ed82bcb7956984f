// SPDX-License-Identifier: GPL-3.0-or-later
// ContinuationOptions: options for following periodic orbits in a parameter.
#pragma once

#include <graze/continuation/conditions/test_function.hpp>
#include <graze/continuation/problems/branch.hpp>
#include <graze/continuation/trace/trace.hpp>
#include <graze/floquet/orbit/shooting.hpp>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace graze {

struct ContinuationOptions {
  std::string parameter = "eta";
  double to = 0.0;                  ///< the branch is followed until the parameter reaches this value
  std::optional<double> from = {};  ///< other end of the range, for branches that turn or are born within it; empty: the start
  int switch_generations = 1;       ///< number of generations of period-doubled branches that are followed
  /// Families of up to this many times the period of the grazing orbit are followed at a hard grazing, within max_period. They
  /// count as a generation. 1: none.
  int max_multiple = 1;
  int max_branches = 64;
  int max_period = 0;            ///< branches of longer period are not followed; 0: no limit
  bool follow_parents = false;   ///< also follow the orbit of half the period to which a doubled branch returns
  int threads = 1;               ///< number of branches followed in parallel; the result does not depend on it
  bool both_directions = false;  ///< also follow the first branch in the other direction, to the end of the range
  TraceOptions trace = {};
  ShootingOptions shooting = {};
  std::vector<double> user_values = {};          ///< parameter values at which points of type UZ are computed
  std::vector<TestFunction> further_tests = {};  ///< evaluated after test_functions()
  std::function<bool()> cancelled = {};
  /// Called after each point with the branch so far (by one thread at a time).
  std::function<void(const Branch&)> progress = {};
  /// Called repeatedly with the complete branches: the result that an interruption would leave.
  std::function<void(const std::vector<Branch>&)> complete = {};
};

}  // namespace graze
