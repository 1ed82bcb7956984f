// SPDX-License-Identifier: GPL-3.0-or-later
// Motions that certainly grow without bound.
//
// Escape from a softening spring, x'' + 2 b x' + k x + beta x^3 = A cos(w t) + c with beta < 0 and b >= 0: with s the sign of x
// and X = |x|, the outward force on a mass at rest is at least
//     F(X) = |beta| X^3 - k X - |A| + s c      (in a Hertz contact also - k_H d^(3/2), d the depth),
// at any phase. Where F > 0 and F grows from there on (F' > 0, F'' > 0), s v >= 0 stays true: a mass that came to rest would be
// pushed outward at once. So X grows beyond every bound, because F stays above its value here.
//
// Undamped resonance, x'' + w^2 x = A cos(w t): without impacts each forcing period adds pi |A| / w^2 to the amplitude, and no
// motion without impacts is periodic.
#pragma once

#include <graze/lib/system/hybrid_system.hpp>

namespace graze {

/// Whether the motion from state x in this mode certainly escapes. False: not certain.
bool escapes(const HybridSystem& system, const Vector& p, std::size_t mode, const Vector& x);

/// Lower bound of the number of forcing periods for which a motion from x at forcing phase 0 grows in undamped resonance before
/// it can meet a barrier. 0: no resonance.
double resonant_periods(const HybridSystem& system, const Vector& p, const Vector& x);

}  // namespace graze
