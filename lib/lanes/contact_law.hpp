// SPDX-License-Identifier: GPL-3.0-or-later
// ContactLaw: a Hertz contact of an oscillator in lanes, with the state and the factors of its series (contact_series.hpp).
#pragma once

#include <graze/lib/lanes/real.hpp>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// A contact at an instant: as HertzState, except for the two columns (z, p) of the tangent.
template <class Real> struct ContactState { Real y, v, c, s, time, divergence, z_0, z_1, p_0, p_1; };

template <class Real> struct ContactLaw {
  Real b2, w, xi, r, k_H, loss, beta;  ///< 2 b, eta, xi, r, k_H, k_H b_H, beta

  /// Factor of dx in the p of a tangent column at depth y^2: half of the damping.
  Real half_damping(const Real& y) const { return 0.5 * madd(loss * y * y, y, b2); }
};

/// Factors of powers of y and of the sine: in dv/ds without losses (pull), in v by its losses (drag), in f.
template <class Real> struct ContactTerms {
  Real w, drive, drag_u, drag_y5;
  Real pull_y, pull_y3, pull_y4, pull_y5, pull_y7;
  Real f_y, f_u, f_y3, f_y4, f_y5, f_y7, f_slope;  ///< f_slope: of d(y^3)/ds

  ContactTerms(const ContactLaw<Real>& law, bool cubic)
      : w(law.w), drive(law.xi / law.w), drag_u(-law.b2), drag_y5(-0.4 * law.loss), pull_y(-law.r), pull_y3(-1.0),
        pull_y4(-law.k_H), pull_y5(0.0), pull_y7(0.0), f_y(1.0 - 0.25 * (law.b2 * law.b2)), f_u(1.5 * law.k_H), f_y3(0.0),
        f_y4(-0.5 * (law.b2 * law.loss)), f_y5(0.0), f_y7(-0.25 * (law.loss * law.loss)), f_slope(0.5 * law.loss) {
    if (!cubic) return;
    const Real beta3 = 3.0 * law.beta, bend = beta3 * law.r, square = law.r * law.r;  // x = r + y^2
    pull_y = pull_y - law.beta * (square * law.r);
    pull_y3 = pull_y3 - beta3 * square;
    pull_y5 = -bend;
    pull_y7 = -law.beta;
    f_y = f_y + beta3 * square;
    f_y3 = 2.0 * bend;
    f_y5 = beta3;
  }
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
