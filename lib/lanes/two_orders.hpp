// SPDX-License-Identifier: GPL-3.0-or-later
// TwoOrders: two successive coefficients of products of power series at once. Each coefficient that is loaded serves both, which
// halves the loads; they, not the arithmetic, are what sums of products in wide registers wait for.
#pragma once

#include <graze/lib/lanes/real.hpp>

#include <cstddef>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Of the products of a series a with N others, and of its square if Squared, a and they being known up to coefficient K:
///     first  = sum of a_i b_j over i + j = K,
///     second = the same over i + j = K + 1 but for i = 0 and j = 0 (which wait for coefficient K + 1);
/// of the square one half of either.
template <class Real, std::size_t K, std::size_t N, bool Squared> struct TwoOrders {
  Real first[N], second[N], first_square, second_square;

  template <class... Series>
  [[gnu::always_inline]] explicit TwoOrders(const Real* a, const Series*... series) : first_square(0.0), second_square(0.0) {
    static_assert(sizeof...(Series) == N);
    const Real* const b[N] = {series...};
    for (std::size_t n = 0; n < N; ++n) first[n] = second[n] = Real(0.0);
    // From the middle on: what was computed last comes last, and need not be waited for.
    constexpr std::size_t middle = (K + 1) / 2;
    Real a_low = a[middle], b_low[N];
    for (std::size_t n = 0; n < N; ++n) b_low[n] = b[n][middle];
    if constexpr (K % 2 == 0) {
      for (std::size_t n = 0; n < N; ++n) first[n] = a_low * b_low[n];
      if constexpr (Squared) first_square = (0.5 * a_low) * a_low;
    } else {
      const Real a_high = a_low;
      a_low = a[middle - 1];
      for (std::size_t n = 0; n < N; ++n) {
        second[n] = a_high * b_low[n];
        first[n] = a_low * b_low[n];
        b_low[n] = b[n][middle - 1];
        first[n] = madd(a_high, b_low[n], first[n]);
      }
      if constexpr (Squared) {
        second_square = (0.5 * a_high) * a_high;
        first_square = a_low * a_high;
      }
    }
#pragma GCC unroll 1
    for (std::size_t j = middle + 1; j <= K; ++j) {
      const Real a_high = a[j];
      if constexpr (Squared) second_square = madd(a_low, a_high, second_square);
      const Real a_before = a_low;
      a_low = a[K - j];
      if constexpr (Squared) first_square = madd(a_low, a_high, first_square);
      for (std::size_t n = 0; n < N; ++n) {
        const Real b_high = b[n][j];
        second[n] = madd(a_high, b_low[n], madd(a_before, b_high, second[n]));
        b_low[n] = b[n][K - j];
        first[n] = madd(a_high, b_low[n], madd(a_low, b_high, first[n]));
      }
    }
  }
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
