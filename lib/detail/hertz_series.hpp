// SPDX-License-Identifier: GPL-3.0-or-later
// HertzSeries: Taylor series in s of a Hertz contact in regularising variables (hertz_flow.hpp), of its tangent and of its
// derivatives in the parameters. With y = sqrt(x - r), u = y^2, dt = y ds the powers of y are products of series, and what
// multiplies the speed v = 2 dy/ds integrates by itself: y v = du/ds, y^4 v = (2/5) d(y^5)/ds. Hence
//     dv/ds = xi y cos - r y - y^3 - beta y x^3 - k_H y^4 - d/ds (2 b u + (2/5) k_H b_H y^5),
//     d(cos, sin)/ds = eta y (-sin, cos),   dt/ds = y,   d(ln det)/ds = -(2 b y + k_H b_H y^4).
// A column (dx, dv) of the tangent, at fixed time, is carried as (dx, q), q = dv + (2 b + k_H b_H y^3) dx:
//     d(dx)/ds = y q - (2 b y + k_H b_H y^4) dx,   dq/ds = -(y + 3 beta y x^2 + (3/2) k_H y^2) dx + y f_p.
// Two quantities at a time lie in one SSE2 register; the recurrence is unrolled; nothing is allocated.
#pragma once

#include <graze/lib/detail/pair.hpp>
#include <graze/lib/hertz_contact.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace graze::detail {

/// A contact at an instant. Columns of the tangent go two by two: dx[j] holds those of columns 2 j and 2 j + 1.
template <std::size_t Pairs> struct HertzState {
  Pair yv = {0.0, 0.0};     ///< y and v
  Pair phase = {1.0, 0.0};  ///< cosine and sine of the forcing's phase
  Pair time = {0.0, 0.0};   ///< since the start of the contact; and the integral of trace(f_x) over it
  std::array<Pair, Pairs> dx{}, q{};
};

template <std::size_t Order, std::size_t Pairs> class HertzSeries {
 public:
  using C = HertzContact;
  using State = HertzState<Pairs>;

  /// `sources`: the coefficients that columns 2, 3, ... of the tangent are derivatives in; t0: where HertzState::time is 0.
  HertzSeries(const C& contact, const std::vector<std::size_t>& sources, double t0)
      : sources_(sources), t0_(t0),
        cubic_(contact.value[C::beta] != 0.0 || std::find(sources.begin(), sources.end(), C::beta) != sources.end()),
        r_(contact.value[C::barrier]), xi_(contact.value[C::amplitude]), k_H_(contact.value[C::stiffness]),
        b_H_(contact.value[C::contact_damping]), beta_(contact.value[C::beta]),
        b2_(2.0 * contact.value[C::damping]), turn_{-contact.value[C::frequency], contact.value[C::frequency]} {}

  /// The series of the motion through z.
  void expand(const State& z) {
    const double y0 = z.yv[0], u0 = y0 * y0;
    yv_[0] = z.yv;
    phase_[0] = z.phase;
    time_[0] = z.time;
    yy_[0] = Pair{y0, y0};
    yu_[0] = Pair{y0, u0};
    u4_[0] = Pair{u0, u0 * u0};
    p35_[0] = y0 * u4_[0];
    y7_[0] = u0 * p35_[0][1];
    u5_[0] = Pair{u0, p35_[0][1]};
    p52_[0] = Pair{p35_[0][1], u0};
    weight_ = Pair{b2_ + 2.0 * loss5_ * y0 * u0, loss5_ * y0};
    weight_y_ = 2.0 * (b2_ * y0 + loss_ * u0 * u0);
    for (std::size_t j = 0; j < Pairs; ++j) {
      dx_[j][0] = z.dx[j];
      q_[j][0] = z.q[j];
    }
    expand(std::make_index_sequence<Order>());
  }

  /// Its sum at s.
  State at(double s) const {
    State z;
    z.yv = horner(yv_, s);
    z.phase = horner(phase_, s);
    z.time = horner(time_, s);
    for (std::size_t j = 0; j < Pairs; ++j) {
      z.dx[j] = horner(dx_[j], s);
      z.q[j] = horner(q_[j], s);
    }
    return z;
  }
  Pair depth_and_speed(double s) const { return horner(yv_, s); }
  double time(double s) const { return horner(time_, s)[0]; }

  /// Largest coefficient of order k, each relative to 1 + |what it belongs to|; not finite if one of them is not.
  double size(std::size_t k) const {
    double largest = relative(yv_, k) + relative(phase_, k) + std::abs(time_[k][0]);
    for (std::size_t j = 0; j < Pairs; ++j) largest = std::max({largest, relative(dx_[j], k), relative(q_[j], k)});
    return largest;
  }

 private:
  using Coefficients = std::array<Pair, Order + 1>;
  /// Even and odd powers side by side: half as long a chain.
  static Pair horner(const Coefficients& a, double s) {
    const double square = s * s;
    Pair even = a[Order], odd = a[Order - 1];
    for (std::size_t k = Order; k > 2; k -= 2) {
      even = a[k - 2] + square * even;
      odd = a[k - 3] + square * odd;
    }
    even = a[0] + square * even;
    return even + s * odd;
  }
  static double relative(const Coefficients& a, std::size_t k) {
    return std::max(std::abs(a[k][0]) / (1.0 + std::abs(a[0][0])), std::abs(a[k][1]) / (1.0 + std::abs(a[0][1])));
  }
  /// product<n, 1> of the square of (y, y^2).
  template <std::size_t n> Pair inner_square() const {
    Pair sum{};
    if constexpr (n % 2 == 0) sum = yu_[n / 2] * yu_[n / 2];
    for (std::size_t i = (n - 1) / 2; i > 0; --i) sum += twice_yu_[i] * yu_[n - i];
    return sum;
  }
  template <std::size_t... k> void expand(std::index_sequence<k...>) { (next<k>(), ...); }
  template <std::size_t k> [[gnu::always_inline]] void next();
  double source(std::size_t coefficient, std::size_t k) const;

  const std::vector<std::size_t>& sources_;
  double t0_;
  bool cubic_;
  double r_, xi_, k_H_, b_H_, beta_, b2_, loss_ = k_H_ * b_H_, loss5_ = 0.4 * loss_;  // b2 = 2 b
  Pair turn_, weight_;  // weight: of the inner squares in the speed, weight_y: of the newest y
  double weight_y_;
  Coefficients yv_, phase_, time_;
  Coefficients yy_, yu_, twice_yu_, u4_, p35_;  // (y, y), (y, y^2), (y^2, y^4), (y^3, y^5)
  Coefficients u5_, p52_;                       // (y^2, y^5), (y^5, y^2)
  Coefficients forcing_;                        // y times phase
  Coefficients f_, g_;                          // twice each: what multiplies dx in -dq/ds, and in -d(dx)/ds
  std::array<double, Order + 1> y7_, yx3_;
  std::array<Coefficients, Pairs> dx_, q_;
};

/// Coefficients k + 1 of everything from those up to k.
template <std::size_t Order, std::size_t Pairs> template <std::size_t k> inline void HertzSeries<Order, Pairs>::next() {
  constexpr double inverse = 1.0 / static_cast<double>(k + 1);
  const double y0 = yv_[0][0], u0 = u4_[0][0], y_k = yv_[k][0], y3 = p35_[k][0], y4 = u4_[k][1];
  const Pair forcing = product<k>(yy_, phase_);
  double restoring = r_ * y_k + k_H_ * y4 + y3, cubic = 0.0;
  if (cubic_) {  // y x^2 and y x^3 in powers of y
    cubic = 3.0 * beta_ * (r_ * (r_ * y_k + 2.0 * y3) + p35_[k][1]);
    yx3_[k] = r_ * (r_ * (r_ * y_k + 3.0 * y3) + 3.0 * p35_[k][1]) + y7_[k];
    restoring += beta_ * yx3_[k];
  }
  // Powers of y: first without y_{k+1}, in which they are linear.
  const Pair square = inner_square<k + 1>(), odd = product<k + 1, 1>(yy_, u4_);
  const double y = 0.5 * inverse * yv_[k][1], u = square[0] + 2.0 * y0 * y;
  const double losses = loss5_ * odd[1] + weight_[0] * square[0] + weight_[1] * square[1] + inverse * restoring;
  const double v = (inverse * xi_ * forcing[0] - weight_y_ * y) - losses;
  yv_[k + 1] = Pair{y, v};
  yy_[k + 1] = Pair{y, y};
  yu_[k + 1] = Pair{y, u};
  twice_yu_[k + 1] = 2.0 * yu_[k + 1];
  u4_[k + 1] = Pair{u, square[1] + 2.0 * u0 * u};
  p35_[k + 1] = odd + y * u4_[0] + y0 * u4_[k + 1];
  if (cubic_) {  // y^7 = y^2 y^5, two terms at a time
    u5_[k + 1] = Pair{u, p35_[k + 1][1]};
    p52_[k + 1] = Pair{p35_[k + 1][1], u};
    Pair sum{};
    if constexpr (k % 2 == 1) sum = Pair{u5_[(k + 1) / 2][0] * u5_[(k + 1) / 2][1], 0.0};
    for (std::size_t i = k / 2 + 1; i > 0; --i) sum += u5_[i - 1] * p52_[k + 2 - i];
    y7_[k + 1] = sum[0] + sum[1];
  }
  forcing_[k] = forcing;
  phase_[k + 1] = inverse * turn_ * Pair{forcing[1], forcing[0]};
  const double f = y_k + 1.5 * k_H_ * u4_[k][0] + cubic, g = b2_ * y_k + loss_ * y4;
  f_[k] = Pair{f, f};
  g_[k] = Pair{g, g};
  time_[k + 1] = inverse * Pair{y_k, -g};
#pragma GCC unroll 1
  for (std::size_t j = 0; j < Pairs; ++j) {
    dx_[j][k + 1] = inverse * (product<k>(yy_, q_[j]) - product<k>(g_, dx_[j]));
    q_[j][k + 1] = -inverse * product<k>(f_, dx_[j]);
  }
  if constexpr (Pairs > 1)
    for (std::size_t i = 0; i < sources_.size(); ++i) q_[1 + i / 2][k + 1][i % 2] += inverse * source(sources_[i], k);
}

/// Coefficient k of y times the derivative of the acceleration in a coefficient of the contact (0 for C::count), at fixed (t, x,
/// v).
template <std::size_t Order, std::size_t Pairs>
double HertzSeries<Order, Pairs>::source(std::size_t coefficient, std::size_t k) const {
  const double next = static_cast<double>(k + 1);
  double turning = 0.0;  // t y sin
  if (coefficient == C::frequency) {
    turning = t0_ * forcing_[k][1];
    for (std::size_t i = 0; i <= k; ++i) turning += time_[i][0] * forcing_[k - i][1];
  }
  const std::array<double, C::count + 1> all = {-2.0 * next * yu_[k + 1][1],
                                                cubic_ ? -yx3_[k] : 0.0,
                                                forcing_[k][0],
                                                -xi_ * turning,
                                                k_H_ * (1.5 * u4_[k][0] + b_H_ * next * p35_[k + 1][0]),
                                                -u4_[k][1] - 0.4 * b_H_ * next * p35_[k + 1][1],
                                                -0.4 * k_H_ * next * p35_[k + 1][1],
                                                0.0};
  return all[coefficient];
}

}  // namespace graze::detail
