// SPDX-License-Identifier: GPL-3.0-or-later
// Power series in lanes: their orders and their values.
#pragma once

#include <graze/lib/lanes/real.hpp>

#include <array>
#include <cstddef>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// The length of a step goes as tolerance^(1/order), and its cost as the square of the order plus a large constant part. At
/// small tolerances (such as the default) the high order takes a sixth less time, at 1e-10 the low one does.
inline constexpr std::size_t low_order = 16, high_order = 20;
inline constexpr double small_tolerance = 5e-13;

/// 1/(k + 1), k < high_order.
inline constexpr auto inverses = [] {
  std::array<double, high_order> all{};
  for (std::size_t k = 0; k < high_order; ++k) all[k] = 1.0 / static_cast<double>(k + 1);
  return all;
}();

/// (a[0] + a[1] h + ... - a[0])/h. Even and odd powers are summed separately, in a chain of half the length.
template <class Real, std::size_t N> Real without_first(const std::array<Real, N>& a, const Real& h) {
  static_assert(N % 2 == 1 && N > 4);
  const Real square = h * h;
  Real odd = a[N - 2], even = a[N - 1];  // odd and even powers of the full series
  for (std::size_t k = N - 2; k > 2; k -= 2) {
    odd = madd(square, odd, a[k - 2]);
    even = madd(square, even, a[k - 1]);
  }
  return madd(h, even, odd);
}
template <class Real, std::size_t N> Real sum(const std::array<Real, N>& a, const Real& h) {
  return madd(h, without_first(a, h), a[0]);
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
