// SPDX-License-Identifier: GPL-3.0-or-later
// Runs a transient and determines the period of the motion after it. For an autonomous system a period is a return
// (carry_period in transition.hpp).
#pragma once

#include <graze/floquet/orbit/shooting.hpp>

#include <functional>

namespace graze {

struct SettleOptions {
  int periods = 1000;        ///< forcing periods of transient
  int max_period = 64;       ///< largest period tested on the states after it
  double recurrence = 1e-6;  ///< |x_{k+n} - x_k| / (1 + |x_k|) below which period n is suspected (proved by Newton, not by this)
  std::function<bool()> cancelled = {};  ///< called once per period; may be empty
  FlowOptions flow = {};
};

struct Settled {
  Termination termination = Termination::failed;  ///< resonance: the motion grows, and for longer than the transient lasted
  Vector state;                                   ///< at forcing phase 0, or immediately after a return
  int suspected_period = 0;                       ///< 0: none found up to max_period
  int periods = 0;                                ///< forcing periods carried out
};

/// Simulates from `start` at forcing phase 0. @throws std::invalid_argument for an inadmissible start.
Settled settle(const HybridSystem& system, const Vector& p, const Vector& start, const SettleOptions& options = {});

}  // namespace graze
