// SPDX-License-Identifier: GPL-3.0-or-later
// Two quantities of a Taylor series side by side in one SSE2 register.
#pragma once

#include <array>
#include <cstddef>

namespace graze::detail {

/// Two doubles side by side, + - * entry by entry, also with one double (a vector type of g++ and clang).
using Pair [[gnu::vector_size(16)]] = double;

/// Coefficient n of a product of two series without its first and last `skip` terms. From the middle outwards: what was found
/// last enters last, and no sum waits for it.
template <std::size_t n, std::size_t skip = 0, std::size_t Size>
inline Pair product(const std::array<Pair, Size>& a, const std::array<Pair, Size>& b) {
  Pair one{}, two{};
  if constexpr (n % 2 == 0 && n / 2 >= skip) one = a[n / 2] * b[n / 2];
  for (std::size_t i = n / 2 + 1; i + skip <= n; ++i) {
    one += a[i] * b[n - i];
    two += a[n - i] * b[i];
  }
  return one + two;
}

}  // namespace graze::detail
