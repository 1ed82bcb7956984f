// SPDX-License-Identifier: GPL-3.0-or-later
// search_box: a box of states in which to look for periodic orbits.
#pragma once

#include <graze/lib/motion/propagator.hpp>
#include <graze/lib/motion/transition.hpp>

namespace graze {

struct SearchBox {
  Vector lower, upper;
  /// If no motion from rest or from a displaced start completes its first period: how these ended; then there is nothing to
  /// search. Otherwise Termination::time.
  Termination ended = Termination::time;
  /// Steps per stretch beyond which a start is not worthwhile (FlowOptions::max_steps): several times the steps of the longest
  /// stretch among the motions that determined the box.
  std::size_t max_steps = 0;
};

/// A box that contains the bounded motions: 1.5 times the largest size of motions from rest, of the long-term states of motions
/// that start off the barriers and hit them, and of the barrier distance. Each motion is carried for `periods` forcing periods
/// unless it settles before.
SearchBox search_box(const HybridSystem& system, const Vector& p, const FlowOptions& options = {}, int periods = 300);

}  // namespace graze
