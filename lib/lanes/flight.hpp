// SPDX-License-Identifier: GPL-3.0-or-later
// Flights in lanes: the closed form of linear_flow.hpp, by recurrence. Along a step h the transient turns by e^(-b h) (cos,
// sin)(q h) and the forcing by (cos, sin)(w h), which are tabulated for steps that are halves of each other. A step is taken
// where the Bernstein coefficients of x's Taylor polynomial of degree 5, with a bound of the sixth derivative, show that the
// barrier is not reached, or that the speed stays positive and the end lies before it; where they show the speed positive and the
// end lies beyond, the crossing in between is the only one, and is polished (crossing.hpp). What is too close to a tangency for
// the shortest step is given up: the lanes miss nothing, they leave it to the one-lane path.
#pragma once

#include <graze/lib/lanes/memory.hpp>

namespace graze::lanes {

/// Closer to the barrier than this (relative to 1 + |r|), and not on it by a contact, a motion is given up.
inline constexpr double too_close = 1e-12;

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

/// Far from the barrier: steps of one length, taken as long as both ends lie below the barrier by more than x can rise above
/// the chord, |x''| h^2/8. Ends when no more than `few` lanes can go on; these do so later.
template <class Real> void march(Memory<Real>& m, int few) {
  const double(*row)[Memory<Real>::W] = m.coefficient + turns + 4 * marching_level;
  const Real turn_c = take<Real>(row[0]), turn_s = take<Real>(row[1]), force_c = take<Real>(row[2]), force_s = take<Real>(row[3]);
  const Real P0 = m[start_p], Q0 = m[start_q], C = m[cosine], S = m[sine], h = m[march_step];
  const Real ceiling = m[barrier] - m[offset] - m[cushion];
  Real E = m[spiral_c], F = m[spiral_s], c = m[phase_c], s = m[phase_s], left = m[rest], steps = m[marched];
  const Mask<Real> marching = m.is(Task::marching);
  Mask<Real> goes = marching & (E * P0 + F * Q0 + (C * c + S * s) < ceiling);
  while (count(goes) > few) {
    const Real E1 = E * turn_c - F * turn_s, F1 = F * turn_c + E * turn_s;
    const Real c1 = c * force_c - s * force_s, s1 = s * force_c + c * force_s;
    goes = goes & (left > h) & (E1 * P0 + F1 * Q0 + (C * c1 + S * s1) < ceiling);
    E = select(goes, E1, E);
    F = select(goes, F1, F);
    c = select(goes, c1, c);
    s = select(goes, s1, s);
    left = select(goes, Real(left - h), left);
    steps = select(goes, Real(steps + 1.0), steps);
  }
  const Mask<Real> stops = marching & !goes, went = stops & (steps > Real(0.0));
  m.set(spiral_c, E);
  m.set(spiral_s, F);
  m.set(phase_c, c);
  m.set(phase_s, s);
  m.set(rest, left);
  m.set(flown, stops, Real(m[flown] + steps * h));
  m.set(marched, Real(select(stops, Real(0.0), steps)));
  m.set(level, went, Real(static_cast<double>(marching_level)));
  m.set(tried, went, Real(0.0));
  m.assign(stops, Task::flight);
}

/// A step: its length, and how it turns the transient and the forcing.
template <class Real> struct FlightStep { Real h, turn_c, turn_s, force_c, force_s; };
/// Each lane's, by its level: lengths go by halves, the turns are in a table.
template <class Real> FlightStep<Real> step_of(const Memory<Real>& m, const Real& level) {
  const double(*table)[Memory<Real>::W] = m.coefficient + turns;
  Real H = m[longest];
  if constexpr (width<Real> == 1) {
    const auto i = static_cast<std::size_t>(level);
    const double(*row)[1] = table + 4 * i;
    return {H * (1.0 / static_cast<double>(std::size_t{1} << i)), *row[0], *row[1], *row[2], *row[3]};
  } else {
    FlightStep<Real> out{H, Real(1.0), Real(0.0), Real(1.0), Real(0.0)};
    for (std::size_t i = 0; i < levels; ++i, table += 4, H = 0.5 * H) {
      const auto here = level == Real(static_cast<double>(i));
      out.h = select(here, H, out.h);
      out.turn_c = select(here, take<Real>(table[0]), out.turn_c);
      out.turn_s = select(here, take<Real>(table[1]), out.turn_s);
      out.force_c = select(here, take<Real>(table[2]), out.force_c);
      out.force_s = select(here, take<Real>(table[3]), out.force_s);
    }
    return out;
  }
}

/// One step of every lane in flight.
template <class Real> void fly(Memory<Real>& m) {
  const auto flying = m.is(Task::flight);
  const Real E = m[spiral_c], F = m[spiral_s], P0 = m[start_p], Q0 = m[start_q], c = m[phase_c], s = m[phase_s];
  const Point<Real> z = point(m, Real(E * P0 + F * Q0), Real(E * Q0 - F * P0), c, s);
  const auto from_barrier = (m[at_barrier] > Real(0.5)) & (m[flown] == Real(0.0));
  const Real r = m[barrier], gap = z.x - r;
  const Real g = select(from_barrier, Real(0.0), gap), v = select(from_barrier, least(z.v, Real(0.0)), z.v);
  const auto close = (!from_barrier) & (gap > -too_close * (1.0 + abs(r)));

  const Real l = m[level];
  const auto [h, turn_c, turn_s, force_c, force_s] = step_of(m, l);
  const Real h2 = h * h, h3 = h2 * h, h4 = h2 * h2, h5 = h4 * h, top = z.bound6 * h5;
  Real position[] = {g,
                     (1.0 / 6.0) * v * h,
                     (1.0 / 30.0) * z.a * h2,
                     (1.0 / 120.0) * z.j * h3,
                     (1.0 / 360.0) * z.x4 * h4,
                     (1.0 / 720.0) * z.x5 * h5,
                     (1.0 / 720.0) * top * h};
  const auto below = below_zero(position);
  Real descent[] = {
      -v, -0.2 * z.a * h, -0.05 * z.j * h2, (-1.0 / 60.0) * z.x4 * h3, (-1.0 / 120.0) * z.x5 * h4, (1.0 / 120.0) * top};
  const auto rising = below_zero(descent);
  const auto sure = below | rising;
  const Real left = m[rest];
  const auto ends = sure & (left <= h);

  // Where the step would lead.
  const Real E1 = E * turn_c - F * turn_s, F1 = F * turn_c + E * turn_s;
  const Real c1 = c * force_c - s * force_s, s1 = s * force_c + c * force_s;
  const Real x1 = E1 * P0 + F1 * Q0 + (m[cosine] * c1 + m[sine] * s1 + m[offset]);
  const auto crosses = sure & (!below) & (!ends) & (x1 >= r);
  const auto moves = flying & sure & (!ends) & (!crosses) & (!close);
  const auto stays = flying & (!sure);

  m.set(spiral_c, moves, E1);
  m.set(spiral_s, moves, F1);
  m.set(phase_c, moves, c1);
  m.set(phase_s, moves, s1);
  m.set(flown, moves, Real(m[flown] + h));
  m.set(rest, moves, Real(left - h));
  // Longer steps again where this one was not the result of a search.
  const Real longer = select(m[tried] > Real(0.5), l, largest(Real(l - 1.0), Real(0.0)));
  const Real next_level = select(moves, longer, select(stays, Real(l + 1.0), l));
  m.set(level, next_level);
  m.set(tried, select(stays, Real(1.0), Real(0.0)));
  const auto stop = flying & (ends | crosses);
  m.set(reach, stop, select(ends, left, h));
  m.set(may_cross, stop, select(below, Real(0.0), Real(1.0)));
  m.assign(moves, Task::marching);
  m.assign(stop, Task::crossing);
  m.assign((flying & close) | (stays & (next_level > Real(levels - 0.5))), Task::given_up);
}

}  // namespace graze::lanes
