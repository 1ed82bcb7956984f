// SPDX-License-Identifier: GPL-3.0-or-later
// The oscillator whose orbits with one impact have a closed form (one_impact_orbit.hpp), and its parameters.
#pragma once

#include <graze/lib/models/oscillator.hpp>

#include "support/checks.hpp"
#include "support/one_impact_orbit.hpp"

namespace graze::support {

inline const HybridSystem& newton_oscillator() {
  static const HybridSystem system = make_oscillator("linear", "newton");
  return system;
}

inline Vector parameters_of(const OneImpactParameters& q) {
  return parameters(newton_oscillator(), {{"b", q.b}, {"xi", q.xi}, {"eta", q.eta}, {"r", q.r}, {"k_r", q.k_r}});
}

}  // namespace graze::support
