// SPDX-License-Identifier: GPL-3.0-or-later
// An integrator that shares no code with the library: Gragg-Bulirsch-Stoer extrapolation of the modified midpoint rule in long
// double (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.9), for smooth right-hand sides. It runs
// forwards or backwards in time.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>

namespace graze::support {

template <std::size_t N> using LongState = std::array<long double, N>;

/// The modified midpoint rule over H in n substeps, smoothed: an expansion in (H/n)^2.
template <std::size_t N, class Field>
LongState<N> midpoint_rule(const Field& f, long double t, long double H, int n, const LongState<N>& y, const LongState<N>& dy0) {
  const long double h = H / n;
  LongState<N> before = y, here, dy;
  for (std::size_t i = 0; i < N; ++i) here[i] = y[i] + h * dy0[i];
  for (int m = 1; m < n; ++m) {
    f(t + m * h, here, dy);
    for (std::size_t i = 0; i < N; ++i) {
      const long double next = before[i] + 2.0L * h * dy[i];
      before[i] = here[i];
      here[i] = next;
    }
  }
  f(t + H, here, dy);
  for (std::size_t i = 0; i < N; ++i) here[i] = 0.5L * (before[i] + here[i] + h * dy[i]);
  return here;
}

/// y(t1) from y(t0); `f(t, y, dy)`. The last two extrapolations of every step agree to `tolerance` (1 + |y|).
template <std::size_t N, class Field>
LongState<N> extrapolate(const Field& f, long double t0, long double t1, LongState<N> y, long double tolerance = 1e-17L) {
  constexpr int rows = 10;
  long double t = t0, H = (t1 - t0) / 8.0L;
  while (t != t1) {
    const bool last = std::abs(H) >= std::abs(t1 - t);
    if (last) H = t1 - t;
    std::array<LongState<N>, rows> row, row_before;
    LongState<N> dy0;
    f(t, y, dy0);
    bool accepted = false;
    for (int k = 0; k < rows && !accepted; ++k) {
      const auto K = static_cast<std::size_t>(k);
      row[0] = midpoint_rule<N>(f, t, H, 2 * (k + 1), y, dy0);
      for (std::size_t j = 1; j <= K; ++j) {
        const long double ratio = static_cast<long double>(K + 1) / static_cast<long double>(K + 1 - j);
        for (std::size_t i = 0; i < N; ++i)
          row[j][i] = row[j - 1][i] + (row[j - 1][i] - row_before[j - 1][i]) / (ratio * ratio - 1.0L);
      }
      if (k >= 3) {
        long double worst = 0.0L;
        for (std::size_t i = 0; i < N; ++i)
          worst = std::fmax(worst, std::abs(row[K][i] - row[K - 1][i]) / (1.0L + std::abs(row[K][i])));
        accepted = worst < tolerance;
      }
      if (accepted) y = row[K];
      row_before = row;
    }
    if (!accepted) {
      H /= 2.0L;
      if (!(std::abs(H) > 1e-12L)) throw std::runtime_error("extrapolation: the right-hand side is not smooth enough");
      continue;
    }
    t = last ? t1 : t + H;
    H *= 1.5L;
  }
  return y;
}

}  // namespace graze::support
