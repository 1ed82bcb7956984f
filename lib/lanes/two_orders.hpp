// SPDX-License-Identifier: GPL-3.0-or-later
// TwoOrders: computes two successive coefficients of products of power series at once. Each loaded number serves both, which
// halves the loads: loads, not arithmetic, limit sums of products in wide registers. The number of known coefficients is a
// variable and not a template constant, because separate code for each order would not fit in the instruction cache.
#pragma once

#include <graze/lib/lanes/real.hpp>

#include <array>
#include <cstddef>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Number of known coefficients: none, even or odd.
enum class Known { none, even, odd };

/// Products of a series a with N others and, if Squared, one half of its square. The first `known` coefficients of all series
/// are known. first() is the sum of a_i b_j over i + j = known - 1. second() is the sum over i + j = known and needs the next
/// coefficients, too.
template <class Real, Known Number, std::size_t N, bool Squared> class TwoOrders {
 public:
  template <class... Series>
  [[gnu::always_inline]] explicit TwoOrders(std::size_t known, const Real* a, const Series*... b)
      : known_(known), a_(a), b_{b...} {
    static_assert(sizeof...(Series) == N);
    if constexpr (Number != Known::none) add_up();
  }
  Real first(std::size_t n = 0) const { return first_[n]; }
  Real first_square() const { return first_[N]; }
  [[gnu::always_inline]] Real second(std::size_t n = 0) const {
    if constexpr (Number == Known::none) return a_[0] * b_[n][0];
    return madd(a_[known_], b_[n][0], madd(a_[0], b_[n][known_], second_[n]));
  }
  [[gnu::always_inline]] Real second_square() const {
    if constexpr (Number == Known::none) return (0.5 * a_[0]) * a_[0];
    return madd(a_[0], a_[known_], second_[N]);
  }

 private:
  /// Sums from the middle outwards: the newest coefficients enter last, so that the sum need not wait for them.
  [[gnu::always_inline]] void add_up() {
    const std::size_t middle = known_ / 2;
    Real a_low = a_[middle];
    std::array<Real, N> b_low;
    for (std::size_t n = 0; n < N; ++n) b_low[n] = b_[n][middle];
    if constexpr (Number == Known::odd) {
      for (std::size_t n = 0; n < N; ++n) first_[n] = a_low * b_low[n];
      if constexpr (Squared) first_[N] = (0.5 * a_low) * a_low;
    } else {
      const Real a_high = a_low;
      a_low = a_[middle - 1];
      for (std::size_t n = 0; n < N; ++n) {
        second_[n] = a_high * b_low[n];
        first_[n] = a_low * b_low[n];
        b_low[n] = b_[n][middle - 1];
        first_[n] = madd(a_high, b_low[n], first_[n]);
      }
      if constexpr (Squared) {
        second_[N] = (0.5 * a_high) * a_high;
        first_[N] = a_low * a_high;
      }
    }
#pragma GCC unroll 1
    for (std::size_t j = middle + 1; j < known_; ++j) {
      const Real a_high = a_[j], a_before = a_low;
      a_low = a_[known_ - 1 - j];
      if constexpr (Squared) {
        second_[N] = madd(a_before, a_high, second_[N]);
        first_[N] = madd(a_low, a_high, first_[N]);
      }
      for (std::size_t n = 0; n < N; ++n) {
        const Real b_high = b_[n][j];
        second_[n] = madd(a_high, b_low[n], madd(a_before, b_high, second_[n]));
        b_low[n] = b_[n][known_ - 1 - j];
        first_[n] = madd(a_high, b_low[n], madd(a_low, b_high, first_[n]));
      }
    }
  }

  std::size_t known_;
  const Real* a_;
  std::array<const Real*, N> b_;
  /// The last entry is that of the square. second_ lacks the first and last terms of its sum.
  std::array<Real, N + 1> first_{}, second_{};
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
