// SPDX-License-Identifier: GPL-3.0-or-later
// Termination: how a run ended.
#pragma once

#include <string_view>

namespace graze {

/// How a run or a stretch of it ended; a run that was not carried out counts as failed. escape, resonance: the motion grows
/// without bound (unbounded.hpp). no_return: an autonomous system had no return for the time longest_return (propagator.hpp).
enum class Termination {
  failed,
  time,
  event_limit,
  inadmissible_start,
  integration_failed,
  grazing,
  interrupted,
  escape,
  resonance,
  no_return
};

/// A short text for each.
std::string_view termination_text(Termination reason);

}  // namespace graze
