// SPDX-License-Identifier: GPL-3.0-or-later
// CubicSeries: Taylor series in time of x'' = A cos(w t) + c - 2 b v - k x - beta x^3, of its tangent and of its derivatives in
// the coefficients. With X = x^2 and x^3 = x X by Cauchy products,
//     (n+1) x_{n+1} = v_n,   (n+1) v_{n+1} = A cos_n + c [n = 0] - 2 b v_n - k x_n - beta (x X)_n,
//     (n+1) (cos, sin)_{n+1} = w (-sin, cos)_n,
//     (n+1) dx_{n+1} = dv_n,   (n+1) dv_{n+1} = -2 b dv_n - k dx_n - 3 beta (X dx)_n + (f_p)_n.
// The displacement from the start of the flight is kept beside x, lest a short flight off a barrier drown in the rounding of x.
#pragma once

#include <graze/lib/detail/hertz_series.hpp>

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
      : q_(oscillator.value), sources_(sources), x0_(x0) {}

  /// The series of the motion through z at time t.
  void expand(double t, const State& z) {
    const double w = q_[C::frequency], drag = 2.0 * q_[C::damping], cubic = q_[C::cubic];
    moved_ = z.moved;
    x_[0] = x0_ + z.moved;
    v_[0] = z.v;
    cos_[0] = std::cos(w * t);
    sin_[0] = std::sin(w * t);
    for (std::size_t j = 0; j < Pairs; ++j) {
      dx_[j][0] = z.dx[j];
      dv_[j][0] = z.dv[j];
    }
    for (std::size_t n = 0; n < Order; ++n) {
      const double inverse = 1.0 / static_cast<double>(n + 1);
      double square = n % 2 == 0 ? 0.5 * x_[n / 2] * x_[n / 2] : 0.0, cube = 0.0;
      for (std::size_t i = n / 2 + 1; i <= n; ++i) square += x_[i] * x_[n - i];
      square_[n] = 2.0 * square;
      for (std::size_t i = 0; i <= n; ++i) cube += x_[i] * square_[n - i];
      cube_[n] = cube;
      x_[n + 1] = inverse * v_[n];
      v_[n + 1] = inverse * (q_[C::amplitude] * cos_[n] + (n == 0 ? q_[C::constant] : 0.0) - drag * v_[n] -
                             q_[C::stiffness] * x_[n] - cubic * cube);
      cos_[n + 1] = -inverse * w * sin_[n];
      sin_[n + 1] = inverse * w * cos_[n];
      for (std::size_t j = 0; j < Pairs; ++j) {
        Pair bend{};
        for (std::size_t i = 0; i <= n; ++i) bend += square_[i] * dx_[j][n - i];
        dx_[j][n + 1] = inverse * dv_[j][n];
        dv_[j][n + 1] = -inverse * (drag * dv_[j][n] + q_[C::stiffness] * dx_[j][n] + 3.0 * cubic * bend);
      }
      if constexpr (Pairs > 1)
        for (std::size_t i = 0; i < sources_.size(); ++i) dv_[1 + i / 2][n + 1][i % 2] += inverse * source(sources_[i], t, n);
    }
  }

  /// Its sum h later.
  State at(double h) const {
    State z;
    z.moved = moved_at(h);
    z.v = horner(v_, h);
    for (std::size_t j = 0; j < Pairs; ++j) {
      z.dx[j] = horner(dx_[j], h);
      z.dv[j] = horner(dv_[j], h);
    }
    return z;
  }
  double moved_at(double h) const {
    double sum = 0.0;
    for (std::size_t k = Order; k > 0; --k) sum = h * (x_[k] + sum);
    return moved_ + sum;
  }
  /// Coefficients of x.
  const Series& position() const { return x_; }

  /// Largest coefficient of order k, each relative to 1 + |what it belongs to|; not finite if one of them is not.
  double size(std::size_t k) const {
    double largest = relative(x_, k) + relative(v_, k) + std::abs(cos_[k]) + std::abs(sin_[k]);
    for (std::size_t j = 0; j < Pairs; ++j) {
      for (std::size_t i = 0; i < 2; ++i) {
        largest = std::max(largest, std::abs(dx_[j][k][i]) / (1.0 + std::abs(dx_[j][0][i])));
        largest = std::max(largest, std::abs(dv_[j][k][i]) / (1.0 + std::abs(dv_[j][0][i])));
      }
    }
    return largest;
  }

 private:
  template <class Number> static Number horner(const std::array<Number, Order + 1>& a, double h) {
    Number sum = a[Order];
    for (std::size_t k = Order; k-- > 0;) sum = a[k] + h * sum;
    return sum;
  }
  static double relative(const Series& a, std::size_t k) { return std::abs(a[k]) / (1.0 + std::abs(a[0])); }

  /// Coefficient n of the derivative of the acceleration in a coefficient of the oscillator, at fixed (t, x, v).
  double source(std::size_t coefficient, double t, std::size_t n) const {
    switch (coefficient) {
    case C::damping:
      return -2.0 * v_[n];
    case C::stiffness:
      return -x_[n];
    case C::cubic:
      return -cube_[n];
    case C::amplitude:
      return cos_[n];
    case C::frequency:
      return -q_[C::amplitude] * (t * sin_[n] + (n > 0 ? sin_[n - 1] : 0.0));
    default:
      return n == 0 ? 1.0 : 0.0;
    }
  }

  const std::array<double, C::count>& q_;
  const std::vector<std::size_t>& sources_;
  double x0_, moved_ = 0.0;
  Series x_{}, v_{}, square_{}, cube_{}, cos_{}, sin_{};
  std::array<std::array<Pair, Order + 1>, Pairs> dx_{}, dv_{};
};

}  // namespace graze::detail
