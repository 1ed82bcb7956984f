// SPDX-License-Identifier: GPL-3.0-or-later
// Flights in lanes: the closed form of linear_flow.hpp, from point to point of the Grid. Far from the barrier a motion marches,
// over as many cells at once as it stays far from it. Elsewhere it goes on by a step up to the next point, or a half, a quarter
// ... of it, where the Bernstein coefficients of x's Taylor polynomial of degree 5, with a bound of the sixth derivative, show
// that the barrier is not reached, or that the speed stays positive and the end lies before it; where they show the speed
// positive and the end lies beyond, the crossing in between is the only one, and is polished (crossing.hpp). What is too close to
// a tangency for the shortest step is given up: the lanes miss nothing, they leave it to the one-lane path.
#pragma once

#include <graze/lib/lanes/memory.hpp>

#include <bit>
#include <cstdint>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Closer to the barrier than this (relative to 1 + |r|), and not on it by a contact, a motion is given up.
inline constexpr double too_close = 1e-12;
/// Steps are not halved below this part of a cell.
inline constexpr double shortest_step = 1.0 / 50.0;

/// A flight begins at (x, v) with the forcing's phase (c, s).
template <class Real>
void begin_flight(Memory<Real>& m, const Mask<Real>& where, const Real& x, const Real& v, const Real& c, const Real& s) {
  const Real w = m[frequency], k = m[stiffness], b = m[damping], h = m[cell];
  const Real d = x - (dot(m[cosine], c, m[sine], s) + m[offset]), e = v - w * wedge(m[sine], c, m[cosine], s);
  // Up to the barrier, -x'' = k x + 2 b x' - A cos(w t) - c is below `bend` (the transient's energy e^2 + k d^2 only decays), and
  // x rises above a chord by h^2/8 of that at the most. (Beyond the barrier, by X, it would be k X more, and k h^2/8 < 1.)
  const Real fastest = abs(e) + m[root_k] * abs(d) + m[forced1];
  const Real bend = k * m[barrier] + 2.0 * b * fastest + abs(m[amplitude]) - m[constant];
  m.set(transient_p, where, d);
  m.set(transient_q, where, Real((e + b * d) * m[inverse_rate]));
  m.set(spiral_c, where, Real(1.0));
  m.set(spiral_s, where, Real(0.0));
  m.set(phase_c, where, c);
  m.set(phase_s, where, s);
  m.set(flown, where, Real(0.0));
  const Real above_chord = largest(Real(0.125 * bend * (h * h)), Real(too_close * (1.0 + abs(m[barrier]))));
  m.set(ceiling, where, Real(m[barrier] - above_chord));
}

/// The next step begins so far from the next point of the grid, and may go up to it.
template <class Real> void look_ahead(Memory<Real>& m, const Mask<Real>& where, const Real& distance) {
  m.set(ahead, where, distance);
  m.set(trial, where, distance);
  m.set(tried, where, Real(0.0));
}

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
  m.set(transient_p, marching, dot(c, P, s, Q));
  m.set(transient_q, marching, wedge(c, Q, s, P));
  if constexpr (Tangent) {
    const Real E = m[spiral_c], F = m[spiral_s];
    m.set(spiral_c, marching, wedge(c, E, s, F));
    m.set(spiral_s, marching, dot(c, F, s, E));
  }
  m.set(phase_c, marching, take<Real>(to_c));
  m.set(phase_s, marching, take<Real>(to_s));
  const Real point = m[next_point] + n, length = m[cell];
  const Mask<Real> ends = marching & (point == m[cells]);
  const Mask<Real> sees_no_end = marching & (!ends) & (n == Real(static_cast<double>(points_ahead - 1)));
  m.set(flown, marching, Real(m[flown] + n * length));
  m.set(next_point, marching, Real(point + select(sees_no_end, Real(0.0), Real(1.0))));
  look_ahead(m, marching, length);
  m.assign(marching & !sees_no_end, Task::flight);
  m.assign(ends, Task::period_end);
}

/// Whether the polynomial of degree N with Bernstein coefficients from partial sums of b is <= 0 on the step and < 0 at its end.
template <class Real, std::size_t N> auto below_zero(Real (&b)[N]) {
  Real worst = b[0];
#pragma GCC unroll 8
  for (std::size_t i = 1; i < N; ++i) {
#pragma GCC unroll 8
    for (std::size_t k = N - 1; k >= i; --k) b[k] = b[k] + b[k - 1];
    worst = largest(worst, b[i]);
  }
  return (worst <= Real(0.0)) & (b[N - 1] < Real(0.0));
}

static_assert(widest_cell <= 0.45, "small_circle and decay are no good beyond that");
/// How the transient, with its decay, and the forcing turn in a time h >= 0 of at most a cell.
template <class Real> struct Turn { Real turn_c, turn_s, force_c, force_s; };
template <class Real> [[gnu::always_inline]] inline Turn<Real> turn(const Memory<Real>& m, const Real& h) {
  Turn<Real> out;
  small_circle(Real(m[rate] * h), out.turn_c, out.turn_s);
  small_circle(Real(m[frequency] * h), out.force_c, out.force_s);
  const Real fall = decay(Real(m[damping] * h));
  out.turn_c = fall * out.turn_c;
  out.turn_s = fall * out.turn_s;
  return out;
}

/// One step of every lane in flight.
template <class Real, bool Tangent> void fly(Memory<Real>& m) {
  const Mask<Real> flying = m.is(Task::flight);
  const Real P = m[transient_p], Q = m[transient_q], c = m[phase_c], s = m[phase_s];
  const Point<Real> z = point(m, P, Q, c, s);
  const Mask<Real> from_barrier = (m[off_barrier] > Real(0.5)) & (m[flown] == Real(0.0));
  const Real r = m[barrier], gap = z.x - r;
  const Real g = select(from_barrier, Real(0.0), gap), v = select(from_barrier, least(z.v, Real(0.0)), z.v);
  const Mask<Real> close = (!from_barrier) & (gap > -too_close * (1.0 + abs(r)));

  const Real h = m[trial], left = m[ahead];
  const Real h2 = h * h, h3 = h2 * h, h4 = h2 * h2, h5 = h4 * h, top = z.bound6 * h5;
  Real position[] = {g,
                     (1.0 / 6.0) * v * h,
                     (1.0 / 30.0) * z.a * h2,
                     (1.0 / 120.0) * z.j * h3,
                     (1.0 / 360.0) * z.x4 * h4,
                     (1.0 / 720.0) * z.x5 * h5,
                     (1.0 / 720.0) * top * h};
  const Mask<Real> below = below_zero(position);
  Real descent[] = {
      -v, -0.2 * z.a * h, -0.05 * z.j * h2, (-1.0 / 60.0) * z.x4 * h3, (-1.0 / 120.0) * z.x5 * h4, (1.0 / 120.0) * top};
  const Mask<Real> rising = below_zero(descent);
  const Mask<Real> sure = below | rising;

  // Where the step would lead.
  const Turn<Real> by = turn(m, h);
  const Real P1 = dot(by.turn_c, P, by.turn_s, Q), Q1 = wedge(by.turn_c, Q, by.turn_s, P);
  const Real c1 = wedge(c, by.force_c, s, by.force_s), s1 = dot(s, by.force_c, c, by.force_s);
  const Real x1 = P1 + (dot(m[cosine], c1, m[sine], s1) + m[offset]);
  const Mask<Real> crosses = flying & sure & (!below) & (x1 >= r) & (!close);
  const Mask<Real> moves = flying & sure & (!crosses) & (!close), stays = flying & (!sure);

  m.set(transient_p, moves, P1);
  m.set(transient_q, moves, Q1);
  m.set(phase_c, moves, c1);
  m.set(phase_s, moves, s1);
  if constexpr (Tangent) {
    const Real E = m[spiral_c], F = m[spiral_s];
    m.set(spiral_c, moves, wedge(by.turn_c, E, by.turn_s, F));
    m.set(spiral_s, moves, dot(by.turn_c, F, by.turn_s, E));
  }
  m.set(flown, moves, Real(m[flown] + h));
  // Above the ceiling no march gets away from a point of the grid: the step to the next one follows at once.
  const Real length = m[cell], here = m[next_point];
  const Mask<Real> on_grid = moves & (h >= left), ends = on_grid & (here == m[cells]);
  const Mask<Real> follows = on_grid & (!ends) & (x1 >= m[ceiling]);
  m.set(next_point, follows, Real(here + 1.0));
  m.set(ahead, moves, select(follows, length, Real(left - h)));
  // Longer steps again where this one was not the result of a search.
  const Real longer = least(Real(select(m[tried] > Real(0.5), h, Real(2.0 * h))), Real(left - h));
  m.set(trial, moves, select(follows, length, longer));
  m.set(trial, stays, Real(0.5 * h));
  m.set(tried, select(stays, Real(1.0), Real(0.0)));
  m.assign(on_grid & !follows, Task::marching);
  m.assign(ends, Task::period_end);
  m.assign(crosses, Task::crossing);
  m.assign((flying & close) | (stays & (h < shortest_step * length)), Task::given_up);
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
