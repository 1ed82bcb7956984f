// SPDX-License-Identifier: GPL-3.0-or-later
// Proof of a polynomial's sign on a whole interval, from its Bernstein coefficients.
#pragma once

#include <array>
#include <cstddef>

namespace graze::detail {

/// Whether the polynomial with power coefficients a_0 ... a_N in h is <= 0 on all of [0, H] and < 0 at H, shown by its
/// Bernstein coefficients (it lies in their convex hull).
template <std::size_t N> inline bool stays_below_zero(const std::array<double, N + 1>& a, double H) {
  static constexpr std::array<double, N + 1> inverse_binomial = [] {
    std::array<double, N + 1> inverse{};
    double binomial = 1.0;
    for (std::size_t k = 0; k <= N; ++k) {
      inverse[k] = 1.0 / binomial;
      binomial = binomial * static_cast<double>(N - k) / static_cast<double>(k + 1);
    }
    return inverse;
  }();
  if (!(a[0] <= 0.0)) return false;
  std::array<double, N + 1> b;  // a_k H^k / binomial(N, k)
  double power = 1.0;
#pragma GCC unroll 8
  for (std::size_t k = 0; k <= N; ++k) {
    b[k] = a[k] * power * inverse_binomial[k];
    power *= H;
  }
  // Then b_j = sum_{k <= j} binomial(j, k) b_k, by repeated partial sums.
#pragma GCC unroll 8
  for (std::size_t m = 1; m <= N; ++m) {
#pragma GCC unroll 8
    for (std::size_t k = N; k >= m; --k) b[k] += b[k - 1];
    if (!(b[m] <= 0.0)) return false;
  }
  return b[N] < 0.0;
}

}  // namespace graze::detail
