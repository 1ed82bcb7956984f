// SPDX-License-Identifier: GPL-3.0-or-later
// FlightSeries: the Taylor series in time of a flight x'' + 2 b x' + k x + beta x^3 = A cos(w t) + c and of its 2x2 tangent in
// lanes. The equations are those of flow/cubic_recurrence.hpp, two orders at once (two_orders.hpp), which suits registers that
// hold the same number of many flights.
#pragma once

#include <graze/lib/lanes/power_series.hpp>
#include <graze/lib/lanes/quads.hpp>
#include <graze/lib/lanes/two_orders.hpp>

#include <array>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// A flight at an instant: gap to the barrier (x - r), speed, cosine and sine of the forcing's phase; tangent row by row.
template <class Real> struct FlightState { Real gap, v, c, s, Phi[4]; };

template <class Real> struct FlightLaw {
  Real b2, k, beta, amplitude, w, constant, r;  ///< 2 b, ...; position of the barrier
};

template <class Real, bool Tangent, std::size_t Order> class FlightSeries {
 public:
  static constexpr std::size_t order = Order;
  using Coefficients = std::array<Real, order + 1>;

  FlightSeries(const FlightLaw<Real>& law, const FlightState<Real>& z) : gap_(z.gap), c_(z.c), s_(z.s) {
    x_[0] = law.r + z.gap;
    v_[0] = z.v;
    turn_[0] = Real(1.0);
    bend_[0] = -law.beta * (x_[0] * x_[0]);
    if constexpr (Tangent)
      for (std::size_t i = 0; i < 4; ++i) Phi_[i][0] = z.Phi[i];
    if constexpr (with_quads) put_in_quads(0);
    const Real force_c = law.amplitude * z.c, force_s = law.amplitude * z.s;
    constexpr double third = 1.0 / 3.0;
    const Constants constants{-law.b2,        -law.k,          -third * law.b2,
                              -third * law.k, -2.0 * law.beta, {force_c, -force_s, -force_c, force_s}};
    next_two<Known::none>(law, constants, 0);
#pragma GCC unroll 1
    for (std::size_t k = 2; k < order; k += 2) next_two<Known::even>(law, constants, k);
  }
  /// Coefficients of the gap, except for the first.
  const Coefficients& position() const { return x_; }
  Real gap(const Real& h) const { return madd(h, without_first(x_, h), gap_); }
  Real speed(const Real& h) const { return sum(v_, h); }
  FlightState<Real> at(const Real& h) const {
    const Real square = -h * h;
    Real turned = turn_[order], sine_over_h = turn_[order - 1];  // cos(w h), and sin(w h)/h
    for (std::size_t k = order; k > 2; k -= 2) {
      turned = madd(square, turned, turn_[k - 2]);
      sine_over_h = madd(square, sine_over_h, turn_[k - 3]);
    }
    turned = madd(square, turned, Real(1.0));
    sine_over_h = h * sine_over_h;
    FlightState<Real> z{gap(h), speed(h), wedge(c_, turned, s_, sine_over_h), dot(s_, turned, c_, sine_over_h), {}};
    if constexpr (Tangent)
      for (std::size_t i = 0; i < 4; ++i) z.Phi[i] = sum(Phi_[i], h);
    return z;
  }

  /// Sums of the coefficients of the last order and of the one before, each relative to 1 + |its quantity|; of the tangent,
  /// relative to 1 + its largest entry.
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

  /// Sums of products: of order k with bend_; of order k + 1, without the first and last terms, one half of x x.
  struct Products {
    Real cube, d[2], square;
  };

  /// Coefficients k + 1 and k + 2 of everything from those up to k; bend_ = -beta x^2.
  template <Known Number> [[gnu::always_inline]] void next_two(const FlightLaw<Real>& law, const Constants& q, std::size_t k) {
    constexpr bool first = Number == Known::none;
    const TwoOrders<Real, Number, 0, true> squares(k, x_.data() + 1);
    if constexpr (with_quads) {
      const TwoOrders<Quad, Known::odd, 1, false> products(k + 1, quads_.bend, quads_.columns);
      const auto sums = [](const Quad& of_products, double square) __attribute__((always_inline)) {
        const auto [cube, d_0, d_1, nothing] = numbers(of_products);
        return Products{cube, {d_0, d_1}, square};
      };
      close<first>(k, law, q, sums(products.first(), squares.first_square()));
      put_in_quads(k + 1);
      close<false>(k + 1, law, q, sums(products.second(), squares.second_square()));
      put_in_quads(k + 2);
    } else if constexpr (Tangent) {
      const TwoOrders<Real, Known::odd, 3, false> products(k + 1, bend_.data(), x_.data(), Phi_[0].data(), Phi_[1].data());
      close<first>(k, law, q, {products.first(0), {products.first(1), products.first(2)}, squares.first_square()});
      close<false>(k + 1, law, q, {products.second(0), {products.second(1), products.second(2)}, squares.second_square()});
    } else {
      const TwoOrders<Real, Known::odd, 1, false> cubes(k + 1, bend_.data(), x_.data());
      close<first>(k, law, q, {cubes.first(), {}, squares.first_square()});
      close<false>(k + 1, law, q, {cubes.second(), {}, squares.second_square()});
    }
  }

  static constexpr bool with_quads = Tangent && in_quads<Real>;
  [[gnu::always_inline]] void put_in_quads(std::size_t k) {
    if constexpr (with_quads) {
      quads_.bend[k] = Quad(bend_[k]);
      quads_.columns[k] = {x_[k], Phi_[0][k], Phi_[1][k], 0.0};
    }
  }

  /// Coefficients k + 1 of everything.
  template <bool First>
  [[gnu::always_inline]] void close(std::size_t k, const FlightLaw<Real>& law, const Constants& q, const Products& sums) {
    const double inverse = inverses[k];
    Real force = sums.cube;
    if constexpr (First) force = force + law.constant;
    force = madd(q.force[k % 4], turn_[k], force);
    const Real v = inverse * madd(q.pull, x_[k], madd(q.drag, v_[k], force)), x = inverse * v_[k];
    v_[k + 1] = v;
    x_[k + 1] = x;
    turn_[k + 1] = inverse * law.w * turn_[k];
    bend_[k + 1] = q.twice_bend * madd(x_[0], x, sums.square);
    if constexpr (Tangent)
      for (std::size_t c = 0; c < 2; ++c) {
        const Real dv = Phi_[2 + c][k];
        Phi_[c][k + 1] = inverse * dv;
        Phi_[2 + c][k + 1] = (3.0 * inverse) * madd(q.drag_3, dv, madd(q.pull_3, Phi_[c][k], sums.d[c]));
      }
  }

  [[no_unique_address]] FlightQuads<with_quads, Order> quads_;
  Real gap_, c_, s_;
  Coefficients x_, v_, turn_, bend_, Phi_[4];  // turn: w^k/k!
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
