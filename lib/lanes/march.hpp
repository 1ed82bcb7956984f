// SPDX-License-Identifier: GPL-3.0-or-later
// The march of flights in lanes: far from the barrier, over as many cells of the Grid at once as a motion stays far from it.
#pragma once

#include <graze/lib/lanes/flight.hpp>

#include <bit>
#include <cstdint>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// How many cells from point k of the grid on, one after the other, have both ends below the ceiling: less than points_ahead.
template <class Real> std::int64_t cells_below(const Grid& grid, std::int64_t k, double P, double Q, double ceiling) {
  const double* forced = grid.forced + k;
  if constexpr (width<Real> == 1) {
    std::size_t n = 0;
    while (n < points_ahead && madd(grid.turn_c[n], P, madd(grid.turn_s[n], Q, forced[n])) < ceiling) ++n;
    return static_cast<std::int64_t>(n) - (n > 0 ? 1 : 0);
  } else {
    unsigned below = 0;
    for (std::size_t i = 0; i < points_ahead; i += width<Real>) {
      const Real without_P = madd(take<Real>(&grid.turn_s[i]), Real(Q), Real(Real::load_unaligned(forced + i)));
      const Real x = madd(take<Real>(&grid.turn_c[i]), Real(P), without_P);
      below |= bits(x < Real(ceiling)) << i;
    }
    return std::countr_one(below & (below >> 1) & (~0U >> 1));
  }
}

/// Takes the motions that are on the grid as far as they are far from the barrier, or points_ahead sees. (What each lane has for
/// itself is looked up one by one; the rest is done together.)
template <class Real, bool Tangent> void march(Memory<Real>& m) {
  constexpr std::size_t W = width<Real>;
  const Mask<Real> marching = m.is(Task::marching);
  alignas(64) double over[W] = {}, by_c[W] = {}, by_s[W] = {}, to_c[W] = {}, to_s[W] = {};
  for_each(marching, [&](std::size_t lane) {
    const Grid& grid = *m.grid[lane];
    const auto here = static_cast<std::int64_t>(m.field[next_point][lane]);
    const std::int64_t n =
        cells_below<Real>(grid, here, m.field[transient_p][lane], m.field[transient_q][lane], m.field[ceiling][lane]);
    over[lane] = static_cast<double>(n);
    by_c[lane] = grid.turn_c[static_cast<std::size_t>(n)];
    by_s[lane] = grid.turn_s[static_cast<std::size_t>(n)];
    to_c[lane] = grid.phase_c[here + n];
    to_s[lane] = grid.phase_s[here + n];
  });
  const Real n = take<Real>(over), c = take<Real>(by_c), s = take<Real>(by_s), P = m[transient_p], Q = m[transient_q];
  const Real P1 = dot(c, P, s, Q), Q1 = wedge(c, Q, s, P), c1 = take<Real>(to_c), s1 = take<Real>(to_s);
  m.set(transient_p, marching, P1);
  m.set(transient_q, marching, Q1);
  if constexpr (Tangent) {
    const Real E = m[spiral_c], F = m[spiral_s];
    m.set(spiral_c, marching, wedge(c, E, s, F));
    m.set(spiral_s, marching, dot(c, F, s, E));
  }
  m.set(phase_c, marching, c1);
  m.set(phase_s, marching, s1);
  const Real point = m[next_point] + n, length = m[cell];
  const Mask<Real> ends = marching & (point == m[cells]);
  const Mask<Real> sees_no_end = but_not(marching, ends) & (n == Real(static_cast<double>(points_ahead - 1)));
  m.set(flown, marching, Real(m[flown] + n * length));
  m.set(next_point, marching, Real(point + select(sees_no_end, Real(0.0), Real(1.0))));
  look_ahead(m, marching, length);
  const Mask<Real> flies = but_not(marching, sees_no_end);  // far enough from the barrier for a crossing in the next cell
  m.assign(flies, Task::flight);
  m.assign(flies & (x_after_cell(m, P1, Q1, c1, s1) >= m[barrier]), Task::crossing);
  m.assign(ends, Task::period_end);
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
