// SPDX-License-Identifier: GPL-3.0-or-later
// CubicSeries: Taylor series in time of x'' = A cos(w t) + c - 2 b v - k x - beta x^3, of its tangent and of its derivatives in
// the coefficients. With X = x^2 and x^3 = x X by Cauchy products,
//     (n+1) x_{n+1} = v_n,   (n+1) v_{n+1} = A cos_n + c [n = 0] - 2 b v_n - k x_n - beta (x X)_n,
//     cos_n = w^n/n! (cos, -sin, -cos, sin, ...),
//     (n+1) dx_{n+1} = dv_n,   (n+1) dv_{n+1} = -2 b dv_n - k dx_n - 3 beta (X dx)_n + (f_p)_n.
// The displacement from the start of the flight is kept beside x, lest a short flight off a barrier drown in the rounding of x.
// Two quantities at a time lie in one SSE2 register; the recurrence is unrolled; nothing is allocated.
#pragma once

#include <graze/lib/detail/pair.hpp>
#include <graze/lib/mode_structure.hpp>

#include <cmath>
#include <utility>

namespace graze::detail {

/// A motion at an instant. Columns of the tangent go two by two: dx[j] holds those of columns 2 j and 2 j + 1.
template <std::size_t Pairs> struct CubicState {
  double moved = 0.0, v = 0.0;  ///< displacement from the start of the flight, speed
  std::array<Pair, Pairs> dx{}, dv{};
};

template <std::size_t Order, std::size_t Pairs> class CubicSeries {
 public:
  using C = CubicOscillator;
  using State = CubicState<Pairs>;
  using Series = std::array<double, Order + 1>;

  /// `sources`: the coefficients that columns 2, 3, ... of the tangent are derivatives in; x0: where State::moved is 0.
  CubicSeries(const C& oscillator, const std::vector<std::size_t>& sources, double x0)
      : q_(oscillator.value), sources_(sources), x0_(x0) {
    double turn = 1.0, force = q_[C::amplitude];
    for (std::size_t n = 0; n <= Order; ++n) {
      turns_[n] = turn;
      force_[n] = force;
      const double next = q_[C::frequency] * inverse[n];
      turn *= next;
      force *= next;
    }
  }

  /// The series of the motion through z at time t.
  void expand(double t, const State& z) {
    const double phase = q_[C::frequency] * t;
    t_ = t;
    cos_ = std::cos(phase);
    sin_ = std::sin(phase);
    x_[0] = x0_ + z.moved;
    xv_[0] = Pair{z.moved, z.v};
    square_[0] = x_[0] * x_[0];
    for (std::size_t j = 0; j < Pairs; ++j) {
      dx_[j][0] = z.dx[j];
      dv_[j][0] = z.dv[j];
    }
    expand(std::make_index_sequence<Order>());
  }

  /// Its sum h later.
  State at(double h) const {
    State z;
    const Pair xv = horner(xv_, h);
    z.moved = xv[0];
    z.v = xv[1];
    for (std::size_t j = 0; j < Pairs; ++j) {
      z.dx[j] = horner(dx_[j], h);
      z.dv[j] = horner(dv_[j], h);
    }
    return z;
  }
  /// Coefficients of x.
  const Series& position() const { return x_; }

  /// Sum of the coefficients of order k, each relative to 1 + |what it belongs to|; not finite if one of them is not.
  double size(std::size_t k) const {
    const Pair start{x_[0], xv_[0][1]}, xv = magnitude(xv_[k]) / (1.0 + magnitude(start));
    Pair sum = xv;
    for (std::size_t j = 0; j < Pairs; ++j)
      sum += magnitude(dx_[j][k]) / (1.0 + magnitude(dx_[j][0])) + magnitude(dv_[j][k]) / (1.0 + magnitude(dv_[j][0]));
    return sum[0] + sum[1] + std::abs(force_[k]);
  }

 private:
  using Coefficients = std::array<Pair, Order + 1>;
  static constexpr Series inverse = [] {
    Series all{};
    for (std::size_t n = 0; n <= Order; ++n) all[n] = 1.0 / static_cast<double>(n + 1);
    return all;
  }();
  /// Even and odd powers side by side: half as long a chain.
  static Pair horner(const Coefficients& a, double h) {
    static_assert(Order % 2 == 0);
    const double square = h * h;
    Pair even = a[Order], odd = a[Order - 1];
    for (std::size_t k = Order; k > 2; k -= 2) {
      even = a[k - 2] + square * even;
      odd = a[k - 3] + square * odd;
    }
    return a[0] + h * (odd + h * even);
  }
  static Pair magnitude(Pair a) { return a < 0.0 ? -a : a; }

  /// Coefficient n of the product of the square with a series, but for what its newest coefficient has in it. From the middle
  /// outwards: what was found last enters last.
  template <std::size_t n, class Number> static Number product(const Series& square, const std::array<Number, Order + 1>& a) {
    Number one{}, two{};
    if constexpr (n % 2 == 0 && n > 0) one = square[n / 2] * a[n / 2];
    for (std::size_t i = n / 2 + 1; i < n; ++i) {
      one += square[i] * a[n - i];
      two += square[n - i] * a[i];
    }
    if constexpr (n > 0) two += square[0] * a[n];
    return one + two;
  }
  template <std::size_t... n> void expand(std::index_sequence<n...>) { (next<n>(), ...); }
  template <std::size_t n> [[gnu::always_inline]] void next();
  double source(std::size_t coefficient, std::size_t n) const;
  double cosine(std::size_t n) const {
    const double turned = n % 2 == 0 ? cos_ : sin_;
    return (n + 1) % 4 < 2 ? turns_[n] * turned : -turns_[n] * turned;
  }
  double sine(std::size_t n) const {
    const double turned = n % 2 == 0 ? sin_ : cos_;
    return n % 4 < 2 ? turns_[n] * turned : -turns_[n] * turned;
  }

  const std::array<double, C::count>& q_;
  const std::vector<std::size_t>& sources_;
  double x0_, t_ = 0.0, cos_ = 1.0, sin_ = 0.0;
  Series x_, square_, cube_;
  Series turns_, force_;  // w^n/n!, and A times it
  Coefficients xv_;       // (x - x0, v)
  std::array<Coefficients, Pairs> dx_, dv_;
};

/// Coefficients n + 1 of everything from those up to n.
template <std::size_t Order, std::size_t Pairs> template <std::size_t n> inline void CubicSeries<Order, Pairs>::next() {
  // To the last bit as in cubic_tangent.hpp.
  constexpr std::size_t m = n + 1;
  const double part = inverse[n], drag = part * (-2.0 * q_[C::damping]), stiffness = -q_[C::stiffness], cubic = -q_[C::cubic];
  const double x_n = x_[n], v_n = xv_[n][1], x = part * v_n;
  double square = m % 2 == 0 ? 0.5 * x_[m / 2] * x_[m / 2] : 0.0;
  for (std::size_t i = m / 2 + 1; i < m; ++i) square += x_[i] * x_[m - i];
  square = 2.0 * square + (2.0 * x_[0]) * x;
  double force = force_[n] * (n % 2 == 0 ? cos_ : sin_);
  if constexpr ((n + 1) % 4 >= 2) force = -force;
  if constexpr (n == 0) force += q_[C::constant];
  const double rest = product<n>(square_, x_);
  const double known = drag * v_n + (part * (force + stiffness * x_n) + (part * cubic) * rest);
  const double v = known + square_[n] * (part * (cubic * x_[0]));
  x_[m] = x;
  xv_[m] = Pair{x, v};
  cube_[n] = rest + square_[n] * x_[0];
  square_[m] = square;
  for (std::size_t j = 0; j < Pairs; ++j) {
    const Pair bend = product<n>(square_, dx_[j]);
    dx_[j][m] = part * dv_[j][n];
    dv_[j][m] = (drag * dv_[j][n] + (part * (stiffness * dx_[j][n]) + (part * (3.0 * cubic)) * bend)) +
                square_[n] * (part * ((3.0 * cubic) * dx_[j][0]));
  }
  if constexpr (Pairs > 1)
    for (std::size_t i = 0; i < sources_.size(); ++i) dv_[1 + i / 2][n + 1][i % 2] += part * source(sources_[i], n);
}

/// Coefficient n of the derivative of the acceleration in a coefficient of the oscillator, at fixed (t, x, v).
template <std::size_t Order, std::size_t Pairs>
double CubicSeries<Order, Pairs>::source(std::size_t coefficient, std::size_t n) const {
  switch (coefficient) {
  case C::damping:
    return -2.0 * xv_[n][1];
  case C::stiffness:
    return -x_[n];
  case C::cubic:
    return -cube_[n];
  case C::amplitude:
    return cosine(n);
  case C::frequency:
    return -q_[C::amplitude] * (t_ * sine(n) + (n > 0 ? sine(n - 1) : 0.0));
  default:
    return n == 0 ? 1.0 : 0.0;
  }
}

}  // namespace graze::detail
