// SPDX-License-Identifier: GPL-3.0-or-later
// Flights in lanes: the closed form of linear_flow.hpp, from point to point of the Grid. If a bound of the curvature shows that
// x stays clear of the barrier between two points, a motion marches (march.hpp). Otherwise it takes a step up to the next
// point, or a half, a quarter ... of it. The Bernstein coefficients of x's Taylor polynomial of degree 5, with a bound of the
// sixth derivative, must show one of three cases: the barrier is not reached; or the speed stays positive and the end lies
// before the barrier; or the speed stays positive and the end lies beyond it. In the last case the crossing in between is the
// only one, and is polished (crossing.hpp). A motion too close to a tangency for the shortest step is given up: the lanes miss
// nothing, they leave it to the Propagator.
#pragma once

#include <graze/lib/lanes/memory.hpp>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// A motion closer to the barrier than this (relative to 1 + |r|) is given up, unless a contact put it on the barrier.
inline constexpr double too_close = 1e-12;
/// Steps are not halved below this part of a cell.
inline constexpr double shortest_step = 1.0 / 50.0;

/// The highest x that is not too close to the barrier.
template <class Real> [[gnu::always_inline]] inline Real highest(const Memory<Real>& m) {
  const Real r = m[barrier];
  return r - too_close * (1.0 + abs(r));
}

/// Begins a flight at (x, v) with the forcing's phase (c, s). Returns a bound of |x'|.
template <class Real, bool Tangent>
[[gnu::always_inline]] inline Real begin_flight(Memory<Real>& m, const Mask<Real>& where, const Real& x, const Real& v,
                                                const Real& c, const Real& s) {
  const Real w = m[frequency], k = m[stiffness], b = m[damping], h = m[cell];
  const Real d = x - (dot(m[cosine], c, m[sine], s) + m[offset]), e = v - w * wedge(m[sine], c, m[cosine], s);
  // Up to the barrier, -x'' = k x + 2 b x' - A cos(w t) - c is below `bend` (the transient's energy e^2 + k d^2 only decays),
  // so x rises above a chord by at most `bend` h^2/8. (At a distance X beyond the barrier the bound is larger by k X, and
  // k h^2/8 < 1.)
  const Real fastest = abs(e) + m[root_k] * abs(d) + m[forced1];
  const Real bend = k * m[barrier] + 2.0 * b * fastest + abs(m[amplitude]) - m[constant];
  m.set(transient_p, where, d);
  m.set(transient_q, where, Real((e + b * d) * m[inverse_rate]));
  if constexpr (Tangent) {
    m.set(spiral_c, where, Real(1.0));
    m.set(spiral_s, where, Real(0.0));
  }
  m.set(phase_c, where, c);
  m.set(phase_s, where, s);
  m.set(flown, where, Real(0.0));
  m.set(ceiling, where, least(Real(m[barrier] - 0.125 * bend * (h * h)), highest(m)));
  return fastest;
}

/// Sets the distance to the next point of the grid; the next step may go up to it.
template <class Real> void look_ahead(Memory<Real>& m, const Mask<Real>& where, const Real& distance) {
  m.set(ahead, where, distance);
  m.set(trial, where, distance);
  m.set(tried, where, Real(0.0));
}

/// Position one cell after a point of the grid, without the barrier.
template <class Real>
[[gnu::always_inline]] inline Real x_after_cell(const Memory<Real>& m, const Real& P, const Real& Q, const Real& c,
                                                const Real& s) {
  return dot(m[cell_p], P, m[cell_q], Q) + (dot(m[cell_c], c, m[cell_s], s) + m[offset]);
}
/// Whether x is not too close to the barrier and x_later lies beyond it. If the speed stays positive, the crossing is the only
/// one.
template <class Real> [[gnu::always_inline]] inline auto crosses_from(const Memory<Real>& m, const Real& x, const Real& x_later) {
  return (x_later >= m[barrier]) & (x <= highest(m));
}

/// Whether x stays below highest() between two points of the grid. x lies below the parabola through both points that has the
/// largest curvature x may have (begin_flight). The parabola is `bow` above the middle of the chord. If d, the difference of
/// the two positions, is less than 4 bow, it rises above the higher one by (4 bow - d)^2/(16 bow).
template <class Real> [[gnu::always_inline]] inline auto stays_clear(const Memory<Real>& m, const Real& x, const Real& x_later) {
  const Real four_bows = 4.0 * (m[barrier] - m[ceiling]), lacks = largest(Real(four_bows - abs(Real(x_later - x))), Real(0.0));
  return lacks * lacks < 4.0 * four_bows * (highest(m) - largest(x, x_later));
}

/// Whether the polynomial of degree N - 1, with Bernstein coefficients from repeated partial sums of b, is <= 0 on the step and
/// < 0 at its end.
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
/// Rotation of the transient, with its decay, and of the forcing in a time h >= 0 of at most a cell.
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

/// Motions in flight a time h later, without the barrier.
template <class Real> struct Later {
  Turn<Real> by;
  Real P, Q, c, s, x;
};
template <class Real>
[[gnu::always_inline]] inline Later<Real> later(const Memory<Real>& m, const Real& P, const Real& Q, const Real& c, const Real& s,
                                                const Real& h) {
  const Turn<Real> by = turn(m, h);
  const Real P1 = dot(by.turn_c, P, by.turn_s, Q), Q1 = wedge(by.turn_c, Q, by.turn_s, P);
  const Real c1 = wedge(c, by.force_c, s, by.force_s), s1 = dot(s, by.force_c, c, by.force_s);
  return {by, P1, Q1, c1, s1, P1 + (dot(m[cosine], c1, m[sine], s1) + m[offset])};
}
template <class Real, bool Tangent>
void go_on_to(Memory<Real>& m, const Mask<Real>& where, const Later<Real>& there, const Real& h) {
  m.set(transient_p, where, there.P);
  m.set(transient_q, where, there.Q);
  m.set(phase_c, where, there.c);
  m.set(phase_s, where, there.s);
  if constexpr (Tangent) {
    const Real E = m[spiral_c], F = m[spiral_s];
    m.set(spiral_c, where, wedge(there.by.turn_c, E, there.by.turn_s, F));
    m.set(spiral_s, where, dot(there.by.turn_c, F, there.by.turn_s, E));
  }
  m.set(flown, where, Real(m[flown] + h));
}

/// Starts motions at a point of the grid, at position x, for the next one. They march if they stay clear of the barrier up to
/// it, else they take a step. Returns those that take a step.
template <class Real>
[[gnu::always_inline]] inline Mask<Real> leave_point(Memory<Real>& m, const Mask<Real>& where, const Real& from, const Real& x,
                                                     const Real& x_later) {
  const Mask<Real> follows = and_not(where, stays_clear(m, x, x_later));
  m.set(next_point, where, select(follows, Real(from + 1.0), from));
  m.assign(where, Task::marching);
  m.assign(follows, Task::flight);
  m.assign(follows & crosses_from(m, x, x_later), Task::crossing);
  return follows;
}

/// Handles motions that have reached the next point of the grid. Returns those that continue with a step and not with a march.
template <class Real>
[[gnu::always_inline]] inline Mask<Real> reach_point(Memory<Real>& m, const Mask<Real>& where, const Later<Real>& z) {
  const Real here = m[next_point];
  const Mask<Real> ends = where & (here == m[cells]);
  m.assign(ends, Task::period_end);
  return leave_point(m, and_not(where, ends), here, z.x, x_after_cell(m, z.P, z.Q, z.c, z.s));
}

/// Whether the speed, v at first, is >= 0 for a time h and > 0 at its end.
template <class Real> [[gnu::always_inline]] inline auto rises(const Point<Real>& z, const Real& v, const Real& h) {
  const Real h2 = h * h, h4 = h2 * h2;
  Real descent[] = {-v,
                    -0.2 * z.a * h,
                    -0.05 * z.j * h2,
                    (-1.0 / 60.0) * z.x4 * (h2 * h),
                    (-1.0 / 120.0) * z.x5 * h4,
                    (1.0 / 120.0) * (z.bound6 * (h4 * h))};
  return below_zero(descent);
}

/// One step of every lane in flight.
template <class Real, bool Tangent> void fly(Memory<Real>& m) {
  const Mask<Real> flying = m.is(Task::flight);
  const Real P = m[transient_p], Q = m[transient_q], c = m[phase_c], s = m[phase_s];
  const Point<Real> z = point(m, P, Q, c, s);
  const Mask<Real> from_barrier = (m[off_barrier] > Real(0.5)) & (m[flown] == Real(0.0));
  const Real r = m[barrier], g = select(from_barrier, Real(0.0), Real(z.x - r)),
             v = select(from_barrier, least(z.v, Real(0.0)), z.v);
  const Mask<Real> close = and_not(z.x > highest(m), from_barrier);

  const Real h = m[trial], left = m[ahead];
  const Real h2 = h * h, h3 = h2 * h, h4 = h2 * h2, h5 = h4 * h, top = z.bound6 * h5;
  Real position[] = {g,
                     (1.0 / 6.0) * v * h,
                     (1.0 / 30.0) * z.a * h2,
                     (1.0 / 120.0) * z.j * h3,
                     (1.0 / 360.0) * z.x4 * h4,
                     (1.0 / 720.0) * z.x5 * h5,
                     (1.0 / 720.0) * top * h};
  const Mask<Real> below = below_zero(position), sure = below | rises(z, v, h), stays = and_not(flying, sure);
  const Later<Real> there = later(m, P, Q, c, s, h);
  const Mask<Real> goes = and_not(flying & sure, close), crosses = and_not(goes, below) & (there.x >= r),
                   moves = and_not(goes, crosses);

  go_on_to<Real, Tangent>(m, moves, there, h);
  const Real length = m[cell];
  const Mask<Real> follows = reach_point(m, moves & (h >= left), there);
  m.set(ahead, moves, select(follows, length, Real(left - h)));
  // The step is doubled again, unless this one resulted from a search.
  const Real longer = least(Real(select(m[tried] > Real(0.5), h, Real(2.0 * h))), Real(left - h));
  m.set(trial, moves, select(follows, length, longer));
  m.set(trial, stays, Real(0.5 * h));
  m.set(tried, select(stays, Real(1.0), Real(0.0)));
  m.assign(crosses, Task::crossing);
  m.assign((flying & close) | (stays & (h < shortest_step * length)), Task::given_up);
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
