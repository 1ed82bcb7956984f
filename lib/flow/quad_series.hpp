// SPDX-License-Identifier: GPL-3.0-or-later
// QuadSums: sums over four series side by side, for the recurrences of series_kernels.hpp.
#pragma once

#include <cstddef>

namespace graze::detail {

template <class Machine, std::size_t Order> struct QuadSums {
  using Quad = typename Machine::Quad;
  using Series = double[Order + 1][4];
  static_assert(Order % 2 == 0);
  static constexpr std::size_t all_four = 4;

  /// first + a_1 h + a_2 h^2 + ...: even and odd powers are summed separately, in a chain of half the length.
  static Quad at(const Series& a, const Quad& first, double h) {
    const Quad step = Machine::all(h), square = Machine::all(h * h);
    Quad even = Machine::load(a[Order]), odd = Machine::load(a[Order - 1]);
#pragma GCC unroll 8
    for (std::size_t k = Order; k > 2; k -= 2) {
      even = Machine::fma(square, even, Machine::load(a[k - 2]));
      odd = Machine::fma(square, odd, Machine::load(a[k - 3]));
    }
    return Machine::fma(step, Machine::fma(step, even, odd), first);
  }
  static Quad at(const Series& a, double h) { return at(a, Machine::load(a[0]), h); }

  /// Coefficient k of the product of one series, number `lane` of four, with four, or of four with four. The sum goes from the
  /// middle outwards: the newest coefficients enter last.
  template <std::size_t k, std::size_t lane = all_four>
  [[gnu::always_inline]] static Quad product(const Series& a, const Series& b) {
    Quad one = Machine::all(0.0), two = one;
    if constexpr (k % 2 == 0) one = factor<lane>(a[k / 2]) * Machine::load(b[k / 2]);
#pragma GCC unroll 8
    for (std::size_t i = k / 2 + 1; i < k; ++i) {
      one = Machine::fma(factor<lane>(a[i]), Machine::load(b[k - i]), one);
      two = Machine::fma(factor<lane>(a[k - i]), Machine::load(b[i]), two);
    }
    one = one + two;
    if constexpr (k > 0) {
      one = Machine::fma(factor<lane>(a[k]), Machine::load(b[0]), one);
      one = Machine::fma(factor<lane>(a[0]), Machine::load(b[k]), one);
    }
    return one;
  }

 private:
  template <std::size_t lane> [[gnu::always_inline]] static Quad factor(const double (&a)[4]) {
    if constexpr (lane < all_four)
      return Machine::all(a[lane]);
    else
      return Machine::load(a);
  }
};

}  // namespace graze::detail
