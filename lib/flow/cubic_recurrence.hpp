// SPDX-License-Identifier: GPL-3.0-or-later
// Taylor series in time of x'' = A cos(w t) + c - 2 b v - k x - beta x^3, of its tangent and of its derivatives in the
// coefficients. With X = x^2 and x^3 = x X by Cauchy products, columns (dx, dv),
//     (n+1) x_{n+1} = v_n,   (n+1) v_{n+1} = A cos_n + c [n = 0] - 2 b v_n - k x_n - beta (x X)_n,
//     cos_n = w^n/n! (cos, -sin, -cos, sin, ...),
//     (n+1) dx_{n+1} = dv_n,   (n+1) dv_{n+1} = -2 b dv_n - k dx_n - 3 beta (X dx)_n + (f_p)_n,
// four quantities at a time: P = (x, dx_1, dx_2, 0), V = (v, dv_1, dv_2, 0), and further columns by fours.
// The dependency of one coefficient on the one before, from v_n through X_{n+1} to v_{n+2}, limits the speed: all terms without
// the newest coefficient are summed beforehand.
//
// Compiled for more than one kind of processor (series_kernels.hpp): plain numbers only.
#pragma once

#include <graze/lib/flow/quad_series.hpp>

#include <utility>

namespace graze::detail {

/// Cost per step ~ order^2 and length of a step ~ tolerance^(1/order): -ln(tolerance)/2 is best, 15 at 1e-13.
inline constexpr std::size_t cubic_order = 16;

/// A motion at an instant, with the columns of Phi and then 4 (Quads - 1) of derivatives in coefficients.
template <std::size_t Quads> struct CubicState {
  static constexpr std::size_t columns = 2 + 4 * (Quads - 1);
  /// Displacement from the start of the flight (rounding of x would swamp that of a short one); speed.
  double moved = 0.0, v = 0.0;
  double cosine = 1.0, sine = 0.0;  ///< of the forcing's phase
  double dx[columns] = {}, dv[columns] = {};
};

template <std::size_t Quads> struct CubicTerms {
  using State = CubicState<Quads>;
  enum Coefficient : std::size_t { damping, stiffness, cubic, amplitude, frequency, constant };  ///< as in CubicOscillator
  double q[6];
  double turn[cubic_order + 1], force[cubic_order + 1];  ///< w^n/n!, and A times it
  const std::size_t* sources;                            ///< coefficients for the derivatives in columns 2, 3, ...
  std::size_t source_count;
  double x0, t;  ///< where `moved` is 0; instant of the step's start
  State start;
  double x[cubic_order + 1], square[cubic_order + 1], cube[cubic_order + 1];
  alignas(32) double P[Quads][cubic_order + 1][4], V[Quads][cubic_order + 1][4];
  double last, before;  ///< sums of the coefficients of the last two orders, each relative to 1 + |its quantity|
};

template <class Machine, std::size_t Quads> struct CubicRecurrence {
  using Terms = CubicTerms<Quads>;
  using Quad = typename Machine::Quad;
  using Sums = QuadSums<Machine, cubic_order>;

  static void expand(Terms& s) {
    s.x[0] = s.x0 + s.start.moved;
    s.square[0] = s.x[0] * s.x[0];
    Machine::store(s.P[0][0], Machine::set(s.x[0], s.start.dx[0], s.start.dx[1], 0.0));
    Machine::store(s.V[0][0], Machine::set(s.start.v, s.start.dv[0], s.start.dv[1], 0.0));
    for (std::size_t j = 1; j < Quads; ++j) {
      const double *dx = s.start.dx + 4 * j - 2, *dv = s.start.dv + 4 * j - 2;
      Machine::store(s.P[j][0], Machine::set(dx[0], dx[1], dx[2], dx[3]));
      Machine::store(s.V[j][0], Machine::set(dv[0], dv[1], dv[2], dv[3]));
    }
    expand(s, std::make_index_sequence<cubic_order>());
    Quad last = Machine::all(0.0), before = last;
    const Quad one = Machine::all(1.0);
    for (std::size_t j = 0; j < Quads; ++j) {
      const Quad weight_P = one / (one + Machine::magnitude(Machine::load(s.P[j][0])));
      const Quad weight_V = one / (one + Machine::magnitude(Machine::load(s.V[j][0])));
      const auto add = [&](std::size_t k, const Quad& sum) {
        return Machine::fma(Machine::magnitude(Machine::load(s.P[j][k])), weight_P,
                            Machine::fma(Machine::magnitude(Machine::load(s.V[j][k])), weight_V, sum));
      };
      last = add(cubic_order, last);
      before = add(cubic_order - 1, before);
    }
    const auto size = [&](std::size_t k, const Quad& sum) {
      return Machine::sum(sum) + (s.force[k] < 0.0 ? -s.force[k] : s.force[k]);
    };
    s.last = size(cubic_order, last);
    s.before = size(cubic_order - 1, before);
  }

  /// The motion h after the step's start.
  static void at(const Terms& s, double h, typename Terms::State& to) {
    const double square = -h * h;
    double turned = s.turn[cubic_order], sine_over_h = s.turn[cubic_order - 1];  // cos(w h), and sin(w h)/h
#pragma GCC unroll 8
    for (std::size_t k = cubic_order; k > 2; k -= 2) {
      turned = Machine::fma(square, turned, s.turn[k - 2]);
      sine_over_h = Machine::fma(square, sine_over_h, s.turn[k - 3]);
    }
    turned = Machine::fma(square, turned, 1.0);
    sine_over_h *= h;
    to.cosine = Machine::fma(s.start.cosine, turned, -s.start.sine * sine_over_h);
    to.sine = Machine::fma(s.start.sine, turned, s.start.cosine * sine_over_h);
    alignas(32) double P[4], V[4];
    for (std::size_t j = 0; j < Quads; ++j) {
      const Quad from = j == 0 ? Machine::set(s.start.moved, s.P[0][0][1], s.P[0][0][2], 0.0) : Machine::load(s.P[j][0]);
      Machine::store(P, Sums::at(s.P[j], from, h));
      Machine::store(V, Sums::at(s.V[j], Machine::load(s.V[j][0]), h));
      if (j == 0) {
        to.moved = P[0];
        to.v = V[0];
      }
      const std::size_t first = j == 0 ? 1 : 0, column = j == 0 ? 0 : 4 * j - 2, count = j == 0 ? 2 : 4;
      for (std::size_t i = 0; i < count; ++i) {
        to.dx[column + i] = P[first + i];
        to.dv[column + i] = V[first + i];
      }
    }
  }

 private:
  /// Constants of all orders: the factors of V_n, of P_n, of the products, and of X_n.
  struct Constants {
    Quad drag, pull[Quads], cubic[Quads], cubic_P0[Quads];
    double twice_x0;
  };

  template <std::size_t... n> static void expand(Terms& s, std::index_sequence<n...>) {
    const double beta = -s.q[Terms::cubic];
    Constants c{Machine::all(-2.0 * s.q[Terms::damping]), {}, {}, {}, 2.0 * s.x[0]};
    for (std::size_t j = 0; j < Quads; ++j) {
      c.cubic[j] = j == 0 ? Machine::set(beta, 3.0 * beta, 3.0 * beta, 0.0) : Machine::all(3.0 * beta);
      c.pull[j] = Machine::fma(Machine::all(s.square[0]), c.cubic[j], Machine::all(-s.q[Terms::stiffness]));
      c.cubic_P0[j] = c.cubic[j] * Machine::load(s.P[j][0]);
    }
    (next<n>(s, c), ...);
  }

  /// Coefficients n + 1 of everything from those up to n.
  template <std::size_t n> [[gnu::always_inline]] static void next(Terms& s, const Constants& c) {
    constexpr std::size_t m = n + 1;
    constexpr double inverse = 1.0 / static_cast<double>(m);
    double square = 0.0;
#pragma GCC unroll 8
    for (std::size_t i = m / 2 + 1; i < m; ++i) square = Machine::fma(s.x[i], s.x[m - i], square);
    square += square;
    if constexpr (m % 2 == 0) square = Machine::fma(s.x[m / 2], s.x[m / 2], square);
    double force = s.force[n] * (n % 2 == 0 ? s.start.cosine : s.start.sine);
    if constexpr (m % 4 >= 2) force = -force;
    if constexpr (n == 0) force += s.q[Terms::constant];
    const Quad part = Machine::all(inverse), square_n = Machine::all(s.square[n]);
    const double v_n = s.V[0][n][0];
    for (std::size_t j = 0; j < Quads; ++j) {
      const Quad V = Machine::load(s.V[j][n]);
      // Coefficient n of X P without X_n and P_n, from the middle outwards: the newest coefficients enter last.
      Quad one = Machine::all(0.0), two = one;
      if constexpr (n % 2 == 0 && n > 0) one = Machine::all(s.square[n / 2]) * Machine::load(s.P[j][n / 2]);
#pragma GCC unroll 8
      for (std::size_t i = n / 2 + 1; i < n; ++i) {
        one = Machine::fma(Machine::all(s.square[i]), Machine::load(s.P[j][n - i]), one);
        two = Machine::fma(Machine::all(s.square[n - i]), Machine::load(s.P[j][i]), two);
      }
      Quad next = j == 0 ? Machine::first(force) : Machine::all(0.0);
      if constexpr (n > 1) next = Machine::fma(c.cubic[j], one + two, next);
      next = Machine::fma(c.pull[j], Machine::load(s.P[j][n]), next);
      if constexpr (n > 0) next = Machine::fma(square_n, c.cubic_P0[j], next);
      Machine::store(s.P[j][m], part * V);
      Machine::store(s.V[j][m], part * Machine::fma(c.drag, V, next));
    }
    s.x[m] = inverse * v_n;
    s.square[m] = Machine::fma(c.twice_x0, s.x[m], square);
    if constexpr (Quads > 1) {
      s.cube[n] = 0.0;
      for (std::size_t i = 0; i <= n; ++i) s.cube[n] = Machine::fma(s.x[i], s.square[n - i], s.cube[n]);
      for (std::size_t i = 0; i < s.source_count; ++i) s.V[1 + i / 4][m][i % 4] += inverse * source(s, s.sources[i], n);
    }
  }

  /// Coefficient n of the derivative of the acceleration in a coefficient of the oscillator, at fixed (t, x, v).
  static double source(const Terms& s, std::size_t coefficient, std::size_t n) {
    const auto wave = [&](std::size_t order, double even, double odd) { return s.turn[order] * (order % 2 == 0 ? even : odd); };
    const auto cosine = [&](std::size_t order) {
      const double value = wave(order, s.start.cosine, s.start.sine);
      return (order + 1) % 4 < 2 ? value : -value;
    };
    const auto sine = [&](std::size_t order) {
      const double value = wave(order, s.start.sine, s.start.cosine);
      return order % 4 < 2 ? value : -value;
    };
    switch (coefficient) {
    case Terms::damping:
      return -2.0 * s.V[0][n][0];
    case Terms::stiffness:
      return -s.x[n];
    case Terms::cubic:
      return -s.cube[n];
    case Terms::amplitude:
      return cosine(n);
    case Terms::frequency:
      return -s.q[Terms::amplitude] * (s.t * sine(n) + (n > 0 ? sine(n - 1) : 0.0));
    default:
      return n == 0 ? 1.0 : 0.0;
    }
  }
};

}  // namespace graze::detail
