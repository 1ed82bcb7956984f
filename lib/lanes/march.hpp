// SPDX-License-Identifier: GPL-3.0-or-later
// The march of flights in lanes: crosses at once all cells of the Grid over which a motion stays clear of the barrier.
#pragma once

#include <graze/lib/lanes/flight.hpp>

#include <bit>
#include <cstdint>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Number of successive cells from point k of the grid on that end below the ceiling: less than points_ahead.
template <class Real> std::int64_t cells_below(const Grid& grid, std::int64_t k, double P, double Q, double ceiling) {
  const double* forced = grid.forced + k;
  if constexpr (width<Real> == 1) {
    std::size_t n = 1;
    while (n < points_ahead && madd(grid.turn_c[n], P, madd(grid.turn_s[n], Q, forced[n])) < ceiling) ++n;
    return static_cast<std::int64_t>(n) - 1;
  } else {
    unsigned below = 0;
    for (std::size_t i = 0; i < points_ahead; i += width<Real>) {
      const Real without_P = madd(take<Real>(&grid.turn_s[i]), Real(Q), Real(Real::load_unaligned(forced + i)));
      const Real x = madd(take<Real>(&grid.turn_c[i]), Real(P), without_P);
      below |= bits(x < Real(ceiling)) << i;
    }
    return std::countr_one(below >> 1);
  }
}

/// Carries the marching motions over all cells that end below the ceiling, at most points_ahead - 1, and over one more if they
/// stay clear of the barrier in it. (The first cell, if it ends below the ceiling, needs no check: otherwise the motion would
/// not march. Values that differ between lanes are looked up one by one; the rest is done in all lanes together.)
template <class Real, bool Tangent> void march(Memory<Real>& m) {
  constexpr std::size_t W = width<Real>;
  const Mask<Real> marching = m.is(Task::marching);
  alignas(64) double over[W] = {}, by_c[W] = {}, by_s[W] = {}, to_c[W] = {}, to_s[W] = {}, next_c[W] = {}, next_s[W] = {};
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
    next_c[lane] = grid.phase_c[here + n + 1];
    next_s[lane] = grid.phase_s[here + n + 1];
  });
  const Real n = take<Real>(over), c = take<Real>(by_c), s = take<Real>(by_s), P = m[transient_p], Q = m[transient_q];
  const Real P1 = dot(c, P, s, Q), Q1 = wedge(c, Q, s, P), c1 = take<Real>(to_c), s1 = take<Real>(to_s);
  const Real point1 = m[next_point] + n, x1 = P1 + (dot(m[cosine], c1, m[sine], s1) + m[offset]);
  const Mask<Real> sees_no_end = n == Real(static_cast<double>(points_ahead - 1));
  const Mask<Real> one_more = and_not(point1 < m[cells], sees_no_end) & stays_clear(m, x1, x_after_cell(m, P1, Q1, c1, s1));
  const Real p = m[cell_p], q = m[cell_q], P2 = select(one_more, dot(p, P1, q, Q1), P1),
             Q2 = select(one_more, wedge(p, Q1, q, P1), Q1);
  const Real c2 = select(one_more, take<Real>(next_c), c1), s2 = select(one_more, take<Real>(next_s), s1);
  const Real over_one = select(one_more, Real(1.0), Real(0.0)), point = point1 + over_one, length = m[cell];
  m.set(transient_p, marching, P2);
  m.set(transient_q, marching, Q2);
  if constexpr (Tangent) {
    const Real E = m[spiral_c], F = m[spiral_s], E1 = wedge(c, E, s, F), F1 = dot(c, F, s, E);
    m.set(spiral_c, marching, select(one_more, wedge(p, E1, q, F1), E1));
    m.set(spiral_s, marching, select(one_more, dot(p, F1, q, E1), F1));
  }
  m.set(phase_c, marching, c2);
  m.set(phase_s, marching, s2);
  const Mask<Real> ends = marching & (point == m[cells]), goes_on = and_not(marching, ends) & sees_no_end;
  m.set(flown, marching, Real(m[flown] + (n + over_one) * length));
  m.set(next_point, marching, Real(point + select(goes_on, Real(0.0), Real(1.0))));
  look_ahead(m, marching, length);
  const Mask<Real> flies = and_not(marching, goes_on);  // from a point not too close to the barrier
  m.assign(flies, Task::flight);
  m.assign(flies & (x_after_cell(m, P2, Q2, c2, s2) >= m[barrier]), Task::crossing);
  m.assign(ends, Task::period_end);
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
