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
CyclicBlocks::Pair solution(double a, double b, double c, double d, double f, double g) {
  if (std::abs(c) > std::abs(a)) {
    std::swap(a, c);
    std::swap(b, d);
    std::swap(f, g);
  }
  const double ratio = c / a, y = (g - ratio * f) / (d - ratio * b);
  return {(f - b * y) / a, y};
}

}  // namespace

void CyclicBlocks::solve(const std::vector<Square>& Phi, const std::vector<Pair>& r, std::vector<Pair>& d) {
  const std::size_t n = Phi.size();
  d.resize(n);
  rows_.resize(n);
  // The remainder of the equations eliminated so far: P d_0 + Q d_k = g.
  Square P = Phi[0], Q = {-1.0, 0.0, 0.0, -1.0};
  Pair g = {-r[0][0], -r[0][1]};
  for (std::size_t k = 1; k < n; ++k) {
    std::array<Row, 4> A = {Row{Q[0], Q[1], P[0], P[1], 0.0, 0.0, g[0]}, Row{Q[2], Q[3], P[2], P[3], 0.0, 0.0, g[1]},
                            Row{Phi[k][0], Phi[k][1], 0.0, 0.0, -1.0, 0.0, -r[k][0]},
                            Row{Phi[k][2], Phi[k][3], 0.0, 0.0, 0.0, -1.0, -r[k][1]}};
    reflect(A);
    rows_[k] = {A[0], A[1]};
    P = {A[2][2], A[2][3], A[3][2], A[3][3]};
    Q = {A[2][4], A[2][5], A[3][4], A[3][5]};
    g = {A[2][6], A[3][6]};
  }
  d[0] = solution(P[0] + Q[0], P[1] + Q[1], P[2] + Q[2], P[3] + Q[3], g[0], g[1]);
  for (std::size_t k = n; k-- > 1;) {
    const Pair& next = d[(k + 1) % n];
    const auto right = [&](const Row& row) {
      return row[6] - row[2] * d[0][0] - row[3] * d[0][1] - row[4] * next[0] - row[5] * next[1];
    };
    const Row &upper = rows_[k][0], &lower = rows_[k][1];
    d[k][1] = right(lower) / lower[1];
    d[k][0] = (right(upper) - upper[1] * d[k][1]) / upper[0];
  }
}

}  // namespace graze
