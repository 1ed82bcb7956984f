// SPDX-License-Identifier: GPL-3.0-or-later
// FlightSeries: the Taylor series in time of a flight x'' + 2 b x' + k x + beta x^3 = A cos(w t) + c and of its 2x2 tangent in
// lanes: the equations of detail/cubic_recurrence.hpp, one loop an order for all products, which suits registers that hold the
// same number of many flights.
#pragma once

#include <graze/lib/lanes/power_series.hpp>

#include <array>
#include <utility>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// A flight at an instant: gap to the barrier (x - r), speed, cosine and sine of the forcing's phase; tangent row by row.
template <class Real> struct FlightState { Real gap, v, c, s, Phi[4]; };

template <class Real> struct FlightLaw {
  Real b2, k, beta, amplitude, w, constant, r;  ///< 2 b, ...; position of the barrier
};

template <class Real, bool Tangent> class FlightSeries {
 public:
  /// As detail::cubic_order.
  static constexpr std::size_t order = 16;
  using Coefficients = std::array<Real, order + 1>;

  FlightSeries(const FlightLaw<Real>& law, const FlightState<Real>& z) : gap_(z.gap), c_(z.c), s_(z.s) {
    x_[0] = law.r + z.gap;
    v_[0] = z.v;
    turn_[0] = Real(1.0);
    bend_[0] = -law.beta * (x_[0] * x_[0]);
    if constexpr (Tangent)
      for (std::size_t i = 0; i < 4; ++i) Phi_[i][0] = z.Phi[i];
    const Real force_c = law.amplitude * z.c, force_s = law.amplitude * z.s;
    constexpr double third = 1.0 / 3.0;
    const Constants constants{-law.b2,        -law.k,          -third * law.b2,
                              -third * law.k, -2.0 * law.beta, {force_c, -force_s, -force_c, force_s}};
    expand(law, constants, std::make_index_sequence<order>());
  }
  /// Of the gap, but for the first.
  const Coefficients& position() const { return x_; }
  Real gap(const Real& h) const { return madd(h, without_first(x_, h), gap_); }
  Real speed(const Real& h) const { return sum(v_, h); }
  FlightState<Real> at(const Real& h) const {
    const Real square = -h * h;
    Real turned = turn_[order], turned_away = turn_[order - 1];  // cos(w h), and sin(w h)/h
    for (std::size_t k = order; k > 2; k -= 2) {
      turned = madd(square, turned, turn_[k - 2]);
      turned_away = madd(square, turned_away, turn_[k - 3]);
    }
    turned = madd(square, turned, Real(1.0));
    turned_away = h * turned_away;
    FlightState<Real> z{gap(h), speed(h), wedge(c_, turned, s_, turned_away), dot(s_, turned, c_, turned_away), {}};
    if constexpr (Tangent)
      for (std::size_t i = 0; i < 4; ++i) z.Phi[i] = sum(Phi_[i], h);
    return z;
  }

  /// Sums of the coefficients of the last order and of the one before, each relative to 1 + |what it belongs to|; of the tangent,
  /// to 1 + its largest entry.
  void size(const FlightLaw<Real>& law, Real& last, Real& before) const {
    const Real of_x = 1.0 / (1.0 + abs(x_[0])), of_v = 1.0 / (1.0 + abs(v_[0]));
    const auto state = [&](std::size_t k) {
      return madd(of_x, abs(x_[k]), madd(of_v, abs(v_[k]), Real(abs(law.amplitude) * abs(turn_[k]))));
    };
    last = state(order);
    before = state(order - 1);
    if constexpr (Tangent) {
      const Real of_tangent =
          1.0 / (1.0 + largest(largest(abs(Phi_[0][0]), abs(Phi_[1][0])), largest(abs(Phi_[2][0]), abs(Phi_[3][0]))));
      const auto tangent = [&](std::size_t k) {
        return Real((abs(Phi_[0][k]) + abs(Phi_[1][k])) + (abs(Phi_[2][k]) + abs(Phi_[3][k])));
      };
      last = madd(of_tangent, tangent(order), last);
      before = madd(of_tangent, tangent(order - 1), before);
    }
  }

 private:
  /// -2 b, -k, a third of either, -2 beta; derivatives of A cos.
  struct Constants {
    Real drag, pull, drag_3, pull_3, twice_bend, force[4];
  };

  template <std::size_t... k>
  [[gnu::always_inline]] void expand(const FlightLaw<Real>& law, const Constants& constants, std::index_sequence<k...>) {
    (next<k>(law, constants), ...);
  }

  /// Coefficients k + 1 of everything from those up to k; bend_ = -beta x^2.
  template <std::size_t k> [[gnu::always_inline]] void next(const FlightLaw<Real>& law, const Constants& q) {
    constexpr double inverse = 1.0 / static_cast<double>(k + 1);
    // Coefficient k of bend x and of bend dx, from the middle outwards: what was computed last comes last, and need not be waited
    // for.
    Real cube = Real(0.0), cube_2 = cube, d[2] = {cube, cube}, d_2[2] = {cube, cube};
    if constexpr (k % 2 == 0) {
      const Real middle = bend_[k / 2];
      cube = middle * x_[k / 2];
      if constexpr (Tangent)
        for (std::size_t c = 0; c < 2; ++c) d[c] = middle * Phi_[c][k / 2];
    }
#pragma GCC unroll 8
    for (std::size_t i = (k + 1) / 2; i > 0; --i) {
      const std::size_t low = i - 1, high = k - low;
      cube = madd(bend_[low], x_[high], cube);
      cube_2 = madd(bend_[high], x_[low], cube_2);
      if constexpr (Tangent)
        for (std::size_t c = 0; c < 2; ++c) {
          d[c] = madd(bend_[low], Phi_[c][high], d[c]);
          d_2[c] = madd(bend_[high], Phi_[c][low], d_2[c]);
        }
    }
    cube_2 = madd(q.drag, v_[k], madd(q.force[k % 4], turn_[k], cube_2));
    if constexpr (k == 0) cube_2 = cube_2 + law.constant;
    v_[k + 1] = inverse * (madd(q.pull, x_[k], cube) + cube_2);
    x_[k + 1] = inverse * v_[k];
    turn_[k + 1] = inverse * law.w * turn_[k];
    if constexpr (Tangent)
      for (std::size_t c = 0; c < 2; ++c) {
        const Real linear = madd(q.drag_3, Phi_[2 + c][k], madd(q.pull_3, Phi_[c][k], d_2[c]));
        Phi_[2 + c][k + 1] = (3.0 * inverse) * (d[c] + linear);
        Phi_[c][k + 1] = inverse * Phi_[2 + c][k];
      }
    Real half = Real(0.0);
    if constexpr (k % 2 == 1) half = (0.5 * x_[(k + 1) / 2]) * x_[(k + 1) / 2];
#pragma GCC unroll 8
    for (std::size_t i = k / 2 + 1; i > 0; --i) half = madd(x_[i - 1], x_[k + 2 - i], half);
    bend_[k + 1] = q.twice_bend * half;
  }

  Real gap_, c_, s_;
  Coefficients x_, v_, turn_, bend_, Phi_[4];  // turn: w^k/k!
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
