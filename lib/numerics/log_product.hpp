// SPDX-License-Identifier: GPL-3.0-or-later
// LogProduct: ln|a b c ...|, with one logarithm for as many factors as the range of a double allows.
#pragma once

#include <cmath>

namespace graze {

class LogProduct {
 public:
  void multiply(double factor) {
    product_ *= factor;
    constexpr double largest = 1e150;
    if (const double size = std::abs(product_); size < largest && size > 1.0 / largest) return;
    sum_ += std::log(std::abs(product_));
    product_ = 1.0;
  }
  /// Multiplies by e^log_factor.
  void multiply_exp(double log_factor) { sum_ += log_factor; }
  /// -infinity if a factor was 0, NaN if one was NaN.
  double value() const { return sum_ + std::log(std::abs(product_)); }

 private:
  double product_ = 1.0, sum_ = 0.0;
};

}  // namespace graze
