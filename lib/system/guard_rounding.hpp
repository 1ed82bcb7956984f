// SPDX-License-Identifier: GPL-3.0-or-later
// When a motion lies on a guard, h = 0, and when it rests there, dh/dt = 0: both up to rounding, in the guard's own units. Where
// it rests, the sign of dh/dt a little later decides whether it meets the guard (hybrid_system.hpp).
#pragma once

#include <graze/lib/system/saltation.hpp>

namespace graze {

/// The size of a guard's derivatives: a force has another scale than a gap.
struct GuardScale {
  double dx = 1.0;  ///< largest |dh/dx_i|
  double dt = 0.0;  ///< |dh/dt| at fixed x
};
GuardScale guard_scale(const Guard& guard, double t, const Vector& x, const Vector& p);

/// The |h| up to which a state lies on the guard: guard_tolerance (|D_x h| (1 + |x|) + |D_t h| (1 + |t|)).
double guard_width(const GuardScale& scale, double t, const Vector& x);

/// Whether dh/dt = `rate` is zero in the field f: |rate| <= rest_tolerance (|D_x h| (1 + |f|) + |D_t h|).
bool rests(double rate, const GuardScale& scale, const Vector& f);

/// dh/dt a time `glance` after (t, x), after a midpoint step in field(t, x, out). `f`: the field at (t, x). Afterwards `at` and f
/// are the state and the field there.
template <class Field>
double rate_after(double glance, const Guard& guard, const Field& field, double t, const Vector& x, const Vector& p, Vector& f,
                  Vector& at) {
  at = x + 0.5 * glance * f;
  field(t + 0.5 * glance, at, f);
  at = x + glance * f;
  field(t + glance, at, f);
  return transversality(guard, t + glance, at, f, p);
}

}  // namespace graze
