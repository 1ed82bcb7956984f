// SPDX-License-Identifier: GPL-3.0-or-later
// ContinuationOptions: how periodic orbits are followed in a parameter.
#pragma once

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
  double to = 0.0;                  ///< the branch is followed until the parameter gets here
  std::optional<double> from = {};  ///< other end of the range, for branches that turn or are born on the way; empty: the start
  int switch_generations = 1;       ///< generations of period-doubled branches that are followed
  /// At a hard grazing the families of 2, 3 ... times the period of the orbit that grazes are followed too, up to this many times
  /// (and to max_period). They count as a generation. 1: none of them.
  int max_multiple = 1;
  int max_branches = 64;
  int max_period = 0;            ///< branches of longer period are not followed; 0: no limit
  bool follow_parents = false;   ///< where a doubled branch returns to an orbit of half its period, that one is followed too
  int threads = 1;               ///< branches are followed side by side; the result does not depend on it
  bool both_directions = false;  ///< also follow the first branch the other way, as far as the range goes
  TraceOptions trace = {};
  ShootingOptions shooting = {};
  std::vector<double> user_values = {};  ///< parameter values at which a point of type UZ is wanted
  std::function<bool()> cancelled = {};
  /// Called after each point with the branch so far (by one thread at a time).
  std::function<void(const Branch&)> progress = {};
  /// Called now and then with the branches that are complete, as an interruption would leave them.
  std::function<void(const std::vector<Branch>&)> complete = {};
};

}  // namespace graze
