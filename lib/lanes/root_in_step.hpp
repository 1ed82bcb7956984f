// SPDX-License-Identifier: GPL-3.0-or-later
// Roots of a quantity within one step, in lanes.
#pragma once

#include <graze/lib/lanes/real.hpp>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// The zero in [0, h] of the parabola with value `start` <= 0 and slope `slope` at 0, and value `end` >= 0 at h.
template <class Real> Real parabola_root(const Real& start, const Real& slope, const Real& h, const Real& end) {
  const Real bend = (end - start - slope * h) / (h * h);
  const Real root = -2.0 * start / (slope + sqrt(largest(Real(slope * slope - 4.0 * bend * start), Real(0.0))));
  return least(largest(root, Real(0.0)), h);
}

/// Root by Newton's method from s on, kept in the bracket [0, h]. `value` returns a quantity of a partial step and its
/// derivative; the quantity is negative at 0 and not negative at h. Lanes outside `seeking` keep s.
template <class Real, class Value> Real root_in_step(const Value& value, const Real& h, Real s, Mask<Real> seeking) {
  Real lo = Real(0.0), hi = h;
  for (int i = 0; i < 60 && any(seeking); ++i) {
    const auto [g, slope] = value(s);
    const Mask<Real> below = g < Real(0.0);
    lo = select(seeking & below, s, lo);
    hi = select(and_not(seeking, below), s, hi);
    const Real next = s - g / slope;
    const Mask<Real> inside = (next >= lo) & (next <= hi);
    const Mask<Real> done = inside & (abs(Real(next - s)) <= 1e-9 * h);
    s = select(seeking, select(inside, next, Real(0.5 * (lo + hi))), s);
    seeking = and_not(seeking, done);
  }
  return s;
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
