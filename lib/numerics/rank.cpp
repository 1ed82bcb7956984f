// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/numerics/rank.hpp>

#include <Eigen/LU>

#include <cmath>
#include <limits>

namespace graze {

RankedDeterminant ranked_determinant(const Matrix& A) {
  const Eigen::Index n = A.rows();
  const double small = 8.0 * std::numeric_limits<double>::epsilon() * static_cast<double>(n);
  if (n == 2) {
    const double down = A(0, 0) * A(1, 1), up = A(0, 1) * A(1, 0);
    if (std::abs(down - up) > small * (std::abs(down) + std::abs(up))) return {down - up, 0};
    return {0.0, (A.array() == 0.0).all() ? 2 : 1};
  }
  Matrix scaled = A;
  int scale = 0;
  const auto normalise = [&](auto&& line) {
    const double size = line.template lpNorm<Eigen::Infinity>();
    const int e = size > 0.0 ? std::ilogb(size) : 0;
    line *= std::ldexp(1.0, -e);
    scale += e;
  };
  for (Eigen::Index i = 0; i < n; ++i) normalise(scaled.row(i));
  for (Eigen::Index j = 0; j < n; ++j) normalise(scaled.col(j));
  Eigen::FullPivLU<Matrix> lu(scaled);
  lu.setThreshold(small);
  return {lu.isInvertible() ? std::ldexp(lu.determinant(), scale) : 0.0, n - lu.rank()};
}

}  // namespace graze
