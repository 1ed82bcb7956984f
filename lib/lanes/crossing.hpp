// SPDX-License-Identifier: GPL-3.0-or-later
// The end of a flight at the barrier, in lanes. The crossing is first that of the Taylor polynomial of degree 5, then that of
// the exact motion. Once a correction is small, the polynomial about the new point is exact to rounding.
#pragma once

#include <graze/lib/lanes/march.hpp>

#include <limits>
#include <utility>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// A correction d of a crossing is the last one if it is below this part of a cell and e = (a/v) d is below it, too: the
/// polynomial of degree 5 leaves out (d sqrt(k))^6/720, and Chebyshev's and Newton's steps leave e^5 d/8.
inline constexpr double nearly_there = 2e-3;

/// `times` steps of Newton's method from h for a root of x - r = g + v h + a h^2/2 + ... in [lowest, highest].
template <class Real>
Real polynomial_root(const Point<Real>& z, const Real& g, Real h, const Real& lowest, const Real& highest, int times) {
  const Real a = 0.5 * z.a, j = (1.0 / 6.0) * z.j, x4 = (1.0 / 24.0) * z.x4, x5 = (1.0 / 120.0) * z.x5;
  for (int i = 0; i < times; ++i) {
    const Real value = madd(h, madd(h, madd(h, madd(h, madd(h, x5, x4), j), a), z.v), g);
    const Real slope = madd(h, madd(h, madd(h, madd(h, Real(5.0 * x5), Real(4.0 * x4)), Real(3.0 * j)), Real(2.0 * a)), z.v);
    h = least(largest(Real(h - value / slope), lowest), highest);
  }
  return h;
}

/// Turns (c, s) by a small angle (truncation error at 0.001: 1e-21).
template <class Real> void turn_a_little(const Real& angle, Real& c, Real& s) {
  const Real square = angle * angle, before = c;
  const Real cosine_of = 1.0 - square * (0.5 - (1.0 / 24.0) * square);
  const Real sine_of = angle * (1.0 - square * ((1.0 / 6.0) - (1.0 / 120.0) * square));
  c = wedge(c, cosine_of, s, sine_of);
  s = dot(s, cosine_of, before, sine_of);
}

/// Flights at the barrier: transient, turn and phase there, and the duration of the last step.
template <class Real> struct Arrival {
  Real P, Q, turn_c, turn_s, c, s, h;
  Mask<Real> found, unsure;  ///< unsure: the speed may be negative in between, so that this need not be the first crossing
};

/// The arrival of every lane whose task is Task::crossing, within its step.
template <class Real> Arrival<Real> arrival(const Memory<Real>& m) {
  const Mask<Real> crossing = m.is(Task::crossing);
  const Real P = m[transient_p], Q = m[transient_q], c = m[phase_c], s = m[phase_s], r = m[barrier], farthest = m[trial];
  const Point<Real> start = point(m, P, Q, c, s);
  const Real g0 = start.x - r;  // < 0: no motion rises from the barrier
  const Real parabola = -2.0 * g0 / (start.v + sqrt(largest(Real(start.v * start.v - 2.0 * start.a * g0), Real(0.0))));
  Real h = polynomial_root(start, g0, least(largest(parabola, Real(0.0)), farthest), Real(0.0), farthest, 2);
  Arrival<Real> out{
      P, Q, Real(1.0), Real(0.0), c, s, Real(0.0), mask_of<Real>(0), and_not(crossing, rises(start, start.v, farthest))};
  Mask<Real> seeking = and_not(crossing, out.unsure);
  for (int round = 0; round < 12 && any(seeking); ++round) {
    const Later<Real> there = later(m, P, Q, c, s, h);
    const Point<Real> z = point(m, there.P, there.Q, there.c, there.s);
    Turn<Real> by = there.by;
    const Real g = z.x - r, inverse = 1.0 / z.v, newton = -g * inverse, chebyshev = newton * (1.0 - 0.5 * newton * z.a * inverse);
    const Real move = polynomial_root(z, g, chebyshev, Real(-h), Real(farthest - h), 1);
    const Mask<Real> settled = seeking & (abs(move) < nearly_there * m[cell]) & (abs(Real(move * z.a)) < nearly_there * z.v);
    const Real last = select(settled, move, Real(0.0)), d = -m[damping] * last;
    const Real loss = 1.0 + d * (1.0 + d * (0.5 + d * ((1.0 / 6.0) + d * (1.0 / 24.0))));
    turn_a_little(Real(m[rate] * last), by.turn_c, by.turn_s);
    turn_a_little(Real(m[frequency] * last), by.force_c, by.force_s);
    by.turn_c = loss * by.turn_c;
    by.turn_s = loss * by.turn_s;
    h = h + move;
    out.P = select(settled, dot(by.turn_c, P, by.turn_s, Q), out.P);
    out.Q = select(settled, wedge(by.turn_c, Q, by.turn_s, P), out.Q);
    out.turn_c = select(settled, by.turn_c, out.turn_c);
    out.turn_s = select(settled, by.turn_s, out.turn_s);
    out.c = select(settled, wedge(c, by.force_c, s, by.force_s), out.c);
    out.s = select(settled, dot(s, by.force_c, c, by.force_s), out.s);
    out.h = select(settled, h, out.h);
    out.found = out.found | settled;
    seeking = and_not(seeking, settled);
  }
  return out;
}

/// A = B A for the 2x2 tangent of the period so far. det is multiplied by that of B, or by NaN if that is lost to cancellation
/// between products a thousand times as large (a strongly damped contact).
template <class Real>
void compose(Memory<Real>& m, const Mask<Real>& where, const Real& b00, const Real& b01, const Real& b10, const Real& b11) {
  const Real a00 = m[phi_00], a01 = m[phi_01], a10 = m[phi_10], a11 = m[phi_11];
  m.set(phi_00, where, dot(b00, a00, b01, a10));
  m.set(phi_01, where, dot(b00, a01, b01, a11));
  m.set(phi_10, where, dot(b10, a00, b11, a10));
  m.set(phi_11, where, dot(b10, a01, b11, a11));
  const Real of_b = wedge(b00, b11, b01, b10), lost = 1e-3 * (abs(Real(b00 * b11)) + abs(Real(b01 * b10)));
  m.set(det, where, Real(m[det] * select(abs(of_b) < lost, Real(std::numeric_limits<double>::quiet_NaN()), of_b)));
}

/// Ends a flight, or its part in a period: composes its tangent, from the spiral (E, F), and adds the integral of trace(f_x).
template <class Real, bool Tangent>
void end_flight(Memory<Real>& m, const Mask<Real>& where, const Real& E, const Real& F, const Real& duration) {
  if constexpr (Tangent) {
    const Real b = m[damping];
    m.set(divergence, where, Real(m[divergence] - 2.0 * b * duration));
    const Real S = F * m[inverse_rate];
    compose(m, where, Real(E + b * S), S, Real(-m[stiffness] * S), Real(E - b * S));
  }
}

/// A motion leaves the barrier with speed v < 0 and the time m[rest] left of the period. It is given up if the flight would be
/// too short or the period ends now; else a flight begins. If its speed alone keeps it clear up to the next point of the grid,
/// it goes there at once.
template <class Real, bool Tangent>
void leave_barrier(Memory<Real>& m, const Mask<Real>& where, const Real& v, const Real& c, const Real& s) {
  const Real r = m[barrier], pressing = m[amplitude] * c + m[constant] - 2.0 * m[damping] * v - m[stiffness] * r;
  const Real left = m[rest], h = m[cell];
  Real whole = floor(Real(left * m[inverse_cell])), part = left - whole * h;
  const Mask<Real> at_point = part < 1e-9 * h;
  whole = select(at_point, Real(whole - 1.0), whole);
  part = select(at_point, Real(part + h), part);
  const Mask<Real> goes =
      where & (-1.0 * v > m[slowest_impact]) & (Real(-2.0 * v) > m[shortest_flight] * pressing) & (whole >= Real(0.0));
  const Real fastest = begin_flight<Real, Tangent>(m, goes, r, v, c, s);
  m.set(next_point, goes, Real(m[cells] - whole));
  look_ahead(m, goes, part);
  m.set(off_barrier, goes, Real(1.0));
  m.assign(goes, Task::flight);
  m.assign(and_not(where, goes), Task::given_up);
  // Up to there x'' = A cos(w t) + c - k x - 2 b x' is below `pull`, because x falls by at most fastest * part.
  const Real pull = abs(m[amplitude]) + m[constant] + 2.0 * m[damping] * fastest + m[stiffness] * (fastest * part - r);
  const Mask<Real> clear = goes & (Real(-2.0 * v) > pull * part);
  if (!any(clear)) return;
  const Later<Real> there = later(m, Real(m[transient_p]), Real(m[transient_q]), c, s, part);
  go_on_to<Real, Tangent>(m, clear, there, part);
  look_ahead(m, clear, h);
  reach_point(m, clear, there);
}

/// Lanes that have reached the barrier, at speed `v` and the forcing's phase (c, s).
template <class Real> struct Landing {
  Mask<Real> where;
  Real v, c, s;
};
/// Ends the flights of all lanes whose task is Task::crossing.
template <class Real, bool Tangent> Landing<Real> land(Memory<Real>& m) {
  const Mask<Real> crossing = m.is(Task::crossing);
  const Arrival<Real> end = arrival<Real>(m);
  const Real v = wedge(m[rate], end.Q, m[damping], end.P) + m[frequency] * wedge(m[sine], end.c, m[cosine], end.s);
  const Real duration = m[flown] + end.h;
  const Mask<Real> short_hop = (m[off_barrier] > Real(0.5)) & (duration < m[shortest_flight]);
  const Mask<Real> good = and_not(end.found & (v > m[slowest_impact]), short_hop);
  m.set(rest, good, Real((m[cells] - m[next_point]) * m[cell] + (m[ahead] - end.h)));
  const Real E = m[spiral_c], F = m[spiral_s];
  end_flight<Real, Tangent>(m, good, wedge(end.turn_c, E, end.turn_s, F), dot(end.turn_c, F, end.turn_s, E), duration);
  m.assign(and_not(crossing, good), Task::given_up);
  m.set(trial, end.unsure, Real(0.5 * m[trial]));
  m.set(tried, end.unsure, Real(1.0));
  m.assign(end.unsure, Task::flight);
  return {good, v, end.c, end.s};
}

/// The flight that Carrier steps; CubicFlight has the same interface. The order is that of the contacts.
template <class Number, bool WithTangent, std::size_t Order> struct LinearFlight {
  using Real = Number;
  static constexpr std::size_t order = Order;
  static constexpr bool tangent = WithTangent, cubic = false;

  /// Begins a forcing period at (x, v).
  static void begin_period(Memory<Real>& m, const Mask<Real>& where, const Real& x, const Real& v) {
    const Real x0 = m[side] * x;
    begin_flight<Real, tangent>(m, where, x0, Real(m[side] * v), Real(1.0), Real(0.0));
    const Real x1 = x_after_cell(m, Real(m[transient_p]), Real(m[transient_q]), Real(1.0), Real(0.0));
    look_ahead(m, leave_point(m, where, Real(0.0), x0, x1), Real(m[cell]));
    m.set(off_barrier, where, Real(0.0));
  }
  static void leave_barrier(Memory<Real>& m, const Mask<Real>& where, const Real& v, const Real& c, const Real& s) {
    lanes::leave_barrier<Real, tangent>(m, where, v, c, s);
  }
  static Real spring_at_barrier(const Memory<Real>& m) { return m[stiffness] * m[barrier]; }
  /// The next step of the lanes at a task of flights. Returns the lanes that land.
  static Landing<Real> step(Memory<Real>& m, const Job&, Task task) {
    if (task == Task::crossing) return lanes::land<Real, tangent>(m);
    task == Task::marching ? lanes::march<Real, tangent>(m) : lanes::fly<Real, tangent>(m);
    return {mask_of<Real>(0), Real(0.0), Real(0.0), Real(0.0)};
  }
  /// State at the end of the period.
  static std::pair<Real, Real> end(Memory<Real>& m, const Mask<Real>& where) {
    const Real P = m[transient_p], Q = m[transient_q];
    end_flight<Real, tangent>(m, where, m[spiral_c], m[spiral_s], m[flown]);
    const Real x = P + m[cosine] + m[offset], v = (m[rate] * Q - m[damping] * P) + m[frequency] * m[sine];
    return {m[side] * x, m[side] * v};
  }
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
