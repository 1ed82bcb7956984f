// SPDX-License-Identifier: GPL-3.0-or-later
// SpreadOrder: every index from 0 to n - 1 once, with consecutive indices far apart. The step is coprime to n and near n times
// the golden ratio 0.618.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace graze {

class SpreadOrder {
 public:
  explicit SpreadOrder(std::size_t n) : n_(n) {
    step_ = std::max<std::size_t>(1, static_cast<std::size_t>(0.6180339887 * static_cast<double>(n)));
    while (std::gcd(step_, n) != 1) ++step_;
  }
  std::size_t size() const { return n_; }
  /// The k-th index.
  std::size_t operator[](std::size_t k) const { return k * step_ % n_; }

 private:
  std::size_t n_, step_;
};

}  // namespace graze
