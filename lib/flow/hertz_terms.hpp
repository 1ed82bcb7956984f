// SPDX-License-Identifier: GPL-3.0-or-later
// HertzTerms: the coefficients of the Taylor series of a Hertz contact (hertz_recurrence.hpp) and their inputs.
#pragma once

#include <graze/lib/flow/hertz_step.hpp>
#include <graze/lib/system/hertz_contact.hpp>

namespace graze::detail {

/// A contact at an instant. Quads = 0: without its tangent; otherwise with the columns of Phi and then 4 (Quads - 1) of
/// derivatives in parameters.
template <std::size_t Quads> struct HertzState {
  static constexpr std::size_t columns = Quads == 0 ? 2 : 2 + 4 * (Quads - 1);
  double y = 0.0, v = 0.0;
  double time = 0.0, divergence = 0.0;  ///< since the start of the contact; and the integral of trace(f_x) over it
  double cosine = 1.0, sine = 0.0;      ///< of the forcing's phase
  double dx[columns] = {}, q[columns] = {};
};

template <std::size_t Quads> struct HertzTerms {
  using State = HertzState<Quads>;
  using Series = double[hertz_order + 1];
  using QuadSeries = double[hertz_order + 1][4];
  static constexpr std::size_t more = Quads > 1 ? Quads - 1 : 0;

  double q[HertzContact::count];
  bool with_cubic;             ///< whether y x^2 and y x^3 are needed
  const std::size_t* sources;  ///< coefficients for the derivatives in columns 2, 3, ... (HertzContact::count: none)
  std::size_t source_count;
  double t0;  ///< where State::time is 0
  State start;
  alignas(32) QuadSeries motion;             ///< y, v, time, divergence
  QuadSeries odd, even, roots, twice_roots;  ///< (y^3, y^5, y^7), (y^2, y^4, y^6), (y, y^2, y^3), and twice that
  QuadSeries forced;                         ///< cos, sin, q_1, q_2
  QuadSeries factors, dx;                    ///< of (dx_1, dx_2) in -d(dx)/ds and in -dq/ds; dx_1, dx_2, and again
  QuadSeries more_q[more + 1], more_dx[more + 1];
  Series y_cos, y_sin, yx3;
  double last, before;  ///< largest coefficients of the last two orders, each relative to 1 + |its quantity|
};

/// Coefficient k of y times the derivative of the acceleration in a coefficient of the contact (0 for C::count), at fixed (t,
/// x, v).
template <std::size_t k, class Terms>
[[gnu::always_inline]] inline double source_coefficient(const Terms& s, std::size_t coefficient) {
  using C = HertzContact;
  constexpr double next = k + 1.0;
  switch (coefficient) {
  case C::damping:
    return -2.0 * next * s.even[k + 1][0];
  case C::beta:
    return -s.yx3[k];
  case C::amplitude:
    return s.y_cos[k];
  case C::frequency: {
    double t_y_sin = s.t0 * s.y_sin[k];  // t y sin
    for (std::size_t i = 0; i <= k; ++i) t_y_sin += s.motion[i][2] * s.y_sin[k - i];
    return -s.q[C::amplitude] * t_y_sin;
  }
  case C::barrier:
    return s.q[C::stiffness] * (1.5 * s.even[k][0] + s.q[C::contact_damping] * next * s.odd[k + 1][0]);
  case C::stiffness:
    return -s.even[k][1] - 0.4 * s.q[C::contact_damping] * next * s.odd[k + 1][1];
  case C::contact_damping:
    return -0.4 * s.q[C::stiffness] * next * s.odd[k + 1][1];
  default:
    return 0.0;
  }
}

}  // namespace graze::detail
