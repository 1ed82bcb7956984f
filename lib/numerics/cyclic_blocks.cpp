// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/numerics/cyclic_blocks.hpp>

#include <cmath>
#include <utility>

namespace graze {

namespace {

using Row = std::array<double, 7>;  // coefficients of d_k, d_0, d_{k+1}, and the right-hand side

/// Makes the first two columns of four rows triangular by two reflections. (Unrolling halves the time.)
void reflect(std::array<Row, 4>& A) {
#pragma GCC unroll 2
  for (std::size_t c = 0; c < 2; ++c) {
    double square = 0.0;
#pragma GCC unroll 4
    for (std::size_t i = c; i < 4; ++i) square += A[i][c] * A[i][c];
    const double length = std::copysign(std::sqrt(square), A[c][c]);
    if (length == 0.0) continue;
    std::array<double, 4> u{};
#pragma GCC unroll 4
    for (std::size_t i = c; i < 4; ++i) u[i] = A[i][c];
    u[c] += length;
    const double scale = 1.0 / (length * u[c]);
#pragma GCC unroll 7
    for (std::size_t j = c; j < 7; ++j) {
      double along = 0.0;
#pragma GCC unroll 4
      for (std::size_t i = c; i < 4; ++i) along += u[i] * A[i][j];
      along *= scale;
#pragma GCC unroll 4
      for (std::size_t i = c; i < 4; ++i) A[i][j] -= along * u[i];
    }
  }
}

/// The solution of a two by two system, with pivoting.
Eigen::Vector2d solution(double a, double b, double c, double d, double f, double g) {
  if (std::abs(c) > std::abs(a)) {
    std::swap(a, c);
    std::swap(b, d);
    std::swap(f, g);
  }
  const double ratio = c / a, y = (g - ratio * f) / (d - ratio * b);
  return Eigen::Vector2d((f - b * y) / a, y);
}

}  // namespace

void CyclicBlocks::solve(const std::vector<Matrix>& Phi, const Matrix& r, Matrix& d) {
  const Eigen::Index n = r.cols();
  d.resize(2, n);
  rows_.resize(Phi.size());
  // The remainder of the equations eliminated so far: P d_0 + Q d_k = g.
  Eigen::Matrix2d P = Phi[0], Q = -Eigen::Matrix2d::Identity();
  Eigen::Vector2d g = -r.col(0);
  for (Eigen::Index k = 1; k < n; ++k) {
    const Matrix& M = Phi[static_cast<std::size_t>(k)];
    std::array<Row, 4> A = {
        Row{Q(0, 0), Q(0, 1), P(0, 0), P(0, 1), 0.0, 0.0, g[0]}, Row{Q(1, 0), Q(1, 1), P(1, 0), P(1, 1), 0.0, 0.0, g[1]},
        Row{M(0, 0), M(0, 1), 0.0, 0.0, -1.0, 0.0, -r(0, k)}, Row{M(1, 0), M(1, 1), 0.0, 0.0, 0.0, -1.0, -r(1, k)}};
    reflect(A);
    rows_[static_cast<std::size_t>(k)] = {A[0], A[1]};
    P << A[2][2], A[2][3], A[3][2], A[3][3];
    Q << A[2][4], A[2][5], A[3][4], A[3][5];
    g << A[2][6], A[3][6];
  }
  d.col(0) = solution(P(0, 0) + Q(0, 0), P(0, 1) + Q(0, 1), P(1, 0) + Q(1, 0), P(1, 1) + Q(1, 1), g[0], g[1]);
  for (Eigen::Index k = n; k-- > 1;) {
    const auto next = d.col((k + 1) % n);
    const auto right = [&](const Row& row) {
      return row[6] - row[2] * d(0, 0) - row[3] * d(1, 0) - row[4] * next[0] - row[5] * next[1];
    };
    const auto& [upper, lower] = rows_[static_cast<std::size_t>(k)];
    d(1, k) = right(lower) / lower[1];
    d(0, k) = (right(upper) - upper[1] * d(1, k)) / upper[0];
  }
}

}  // namespace graze
