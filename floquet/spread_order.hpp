// SPDX-License-Identifier: GPL-3.0-or-later
// Every index from 0 to n - 1 once, neighbours far apart: with a step prime to n, near its golden section.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace graze {

inline std::vector<std::size_t> spread_order(std::size_t n) {
  std::size_t step = std::max<std::size_t>(1, static_cast<std::size_t>(0.6180339887 * static_cast<double>(n)));
  while (std::gcd(step, n) != 1) ++step;
  std::vector<std::size_t> order(n);
  for (std::size_t i = 0; i < n; ++i) order[i] = i == 0 ? 0 : (order[i - 1] + step) % n;
  return order;
}

}  // namespace graze
