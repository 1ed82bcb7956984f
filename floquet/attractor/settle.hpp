// SPDX-License-Identifier: GPL-3.0-or-later
// Letting a transient die out, and reading off the period of what it has settled on.
#pragma once

#include <graze/floquet/orbit/shooting.hpp>

#include <functional>

namespace graze {

struct SettleOptions {
  int periods = 1000;        ///< forcing periods of transient
  int max_period = 64;       ///< largest period looked for among the states that follow
  double recurrence = 1e-6;  ///< |x_{k+n} - x_k| / (1 + |x_k|) below which period n is suspected (proved by Newton, not by this)
  std::function<bool()> cancelled = {};  ///< asked once per period; may be empty
  FlowOptions flow = {};
};

struct Settled {
  Termination termination = Termination::failed;  ///< resonance: it grows, and for longer than the transient was
  Vector state;                                   ///< at forcing phase 0
  int suspected_period = 0;                       ///< 0: none found up to max_period
  int periods = 0;                                ///< forcing periods carried out
};

/// Simulates from `start` at forcing phase 0. @throws std::invalid_argument for an inadmissible start or an autonomous system.
Settled settle(const HybridSystem& system, const Vector& p, const Vector& start, const SettleOptions& options = {});

/// What an autonomous motion has settled on, seen at its returns: the events that are counted.
struct SettledReturns {
  Termination termination = Termination::failed;  ///< time: all returns were carried out
  Vector state;                                   ///< halfway between the last return and the one before it
  double duration = 0.0;                          ///< of the last `period` returns
  int returns = 0;                                ///< carried out
  bool repeats = false;                           ///< the states `period` returns apart differ by less than options.recurrence
};

/// Simulates from `start` for options.periods returns and `period` more. `counted`: indices of the events that are returns.
/// longest_return: a return that takes longer ends the motion as Termination::failed.
/// @throws std::invalid_argument for an inadmissible start, or if no event is counted.
SettledReturns settle_on_returns(const HybridSystem& system, const Vector& p, const Vector& start,
                                 const std::vector<std::size_t>& counted, int period, const SettleOptions& options = {},
                                 double longest_return = 1e4);

}  // namespace graze
