// SPDX-License-Identifier: GPL-3.0-or-later
// The end of a flight in lanes: at the barrier, or with the forcing period. The crossing is first that of the Taylor polynomial
// of degree 5, then of the exact motion; where the last correction is small, the polynomial about the new point holds to
// rounding.
#pragma once

#include <graze/lib/lanes/memory.hpp>

namespace graze::lanes {

/// A flight shorter than this off the barrier, and an impact slower than this, are given up (their rounding wants care).
inline constexpr double shortest_flight = 0.06, slowest_impact = 1e-4;

/// A correction of a crossing below this, in which the speed changes by less than a fifth, is the last: what the polynomial of
/// degree 5 leaves out is its sixth power, and two steps of Newton's method from the parabola's root leave nothing.
inline constexpr double nearly_there = 2e-3;

/// Root of x - r = g + v h + a h^2/2 + ... in [lowest, highest]: that of the parabola, then some steps of Newton's method.
template <class Real>
Real polynomial_root(const Point<Real>& z, const Real& g, const Real& lowest, const Real& highest, int times) {
  const Real a = 0.5 * z.a, j = (1.0 / 6.0) * z.j, x4 = (1.0 / 24.0) * z.x4, x5 = (1.0 / 120.0) * z.x5;
  Real h = -2.0 * g / (z.v + sqrt(largest(Real(z.v * z.v - 4.0 * a * g), Real(0.0))));
  h = least(largest(h, lowest), highest);
  Mask<Real> seeking = abs(h) >= Real(0.0);
  for (int i = 0; i < times && any(seeking); ++i) {
    const Real value = g + h * (z.v + h * (a + h * (j + h * (x4 + h * x5))));
    const Real slope = z.v + h * (2.0 * a + h * (3.0 * j + h * (4.0 * x4 + h * (5.0 * x5))));
    const Real better = least(largest(Real(h - value / slope), lowest), highest), move = better - h;
    h = select(seeking, better, h);
    seeking = seeking & (abs(Real(move * move * z.a)) > Real(1e-17) * abs(slope));  // what the move leaves
  }
  return h;
}

/// (c, s) turned by a small angle (0.005: left out 2e-17).
template <class Real> void turn_a_little(const Real& angle, Real& c, Real& s) {
  const Real square = angle * angle, before = c;
  const Real cosine_of = 1.0 - square * (0.5 - (1.0 / 24.0) * square);
  const Real sine_of = angle * (1.0 - square * ((1.0 / 6.0) - (1.0 / 120.0) * square));
  c = c * cosine_of - s * sine_of;
  s = s * cosine_of + before * sine_of;
}

/// Where flights have ended: spiral and phase there, how much longer they took, and whether at the barrier or with the period.
template <class Real> struct FlightEnd {
  Real E, F, c, s, h;
  Mask<Real> at_barrier, at_end;
};

/// The end of the flight of every lane whose task is Task::crossing; a lane that is at neither end has to be given up.
template <class Real> FlightEnd<Real> flight_end(const Memory<Real>& m) {
  const Mask<Real> ending = m.is(Task::crossing);
  const Real E = m[spiral_c], F = m[spiral_s], P0 = m[start_p], Q0 = m[start_q], c = m[phase_c], s = m[phase_s];
  const Real b = m[damping], q = m[rate], w = m[frequency], r = m[barrier], farthest = m[reach];
  const Mask<Real> timed = farthest >= m[rest], may = m[may_cross] > Real(0.5), none = ending & !ending;
  Mask<Real> seeking = ending & !timed, looking = ending & timed;
  FlightEnd<Real> out{E, F, c, s, Real(0.0), none, none};
  Real guess = farthest;
  if (any(seeking | (looking & may))) {
    const Point<Real> z = point(m, Real(E * P0 + F * Q0), Real(E * Q0 - F * P0), c, s);
    const Mask<Real> departing = (m[at_barrier] > Real(0.5)) & (m[flown] == Real(0.0));
    guess = polynomial_root(z, Real(select(departing, Real(0.0), Real(z.x - r))), Real(0.0), farthest, 1);
  }
  Real h = select(timed, farthest, guess);
  for (int round = 0; round < 12; ++round) {
    Real turn_c, turn_s, force_c, force_s;
    circle(Real(q * h), turn_c, turn_s);
    circle(Real(w * h), force_c, force_s);
    const Real fall = decay(Real(b * h));
    Real E1 = fall * (E * turn_c - F * turn_s), F1 = fall * (F * turn_c + E * turn_s), last = Real(0.0);
    Real c1 = c * force_c - s * force_s, s1 = s * force_c + c * force_s;
    Mask<Real> settled = none, beyond = none, ended = looking;
    if (any(seeking | (looking & may))) {
      const Point<Real> z = point(m, Real(E1 * P0 + F1 * Q0), Real(E1 * Q0 - F1 * P0), c1, s1);
      const Real g = z.x - r, move = polynomial_root(z, g, Real(-h), Real(farthest - h), 2);
      beyond = looking & may & (g >= Real(0.0));
      ended = looking & !beyond;
      settled = seeking & (abs(move) < Real(nearly_there)) & (abs(Real(move * z.a)) < 0.2 * z.v);
      last = select(settled, move, Real(0.0));
      turn_a_little(Real(q * last), E1, F1);
      turn_a_little(Real(w * last), c1, s1);
      const Real d = -b * last, loss = 1.0 + d * (1.0 + d * (0.5 + d * ((1.0 / 6.0) + d * (1.0 / 24.0))));
      E1 = loss * E1;
      F1 = loss * F1;
      h = select(beyond, guess, Real(h + move));
    }
    const Mask<Real> done = ended | settled;
    out.E = select(done, E1, out.E);
    out.F = select(done, F1, out.F);
    out.c = select(done, c1, out.c);
    out.s = select(done, s1, out.s);
    out.h = select(done, select(ended, farthest, h), out.h);
    out.at_barrier = out.at_barrier | settled;
    out.at_end = out.at_end | ended;
    seeking = (seeking & !settled) | beyond;
    looking = none;
    if (!any(seeking)) break;
  }
  return out;
}

/// A = B A for the 2x2 tangent of the period so far; det is multiplied by that of B.
template <class Real>
void compose(Memory<Real>& m, const Mask<Real>& where, const Real& b00, const Real& b01, const Real& b10, const Real& b11) {
  const Real a00 = m[phi_00], a01 = m[phi_01], a10 = m[phi_10], a11 = m[phi_11];
  m.set(phi_00, where, Real(b00 * a00 + b01 * a10));
  m.set(phi_01, where, Real(b00 * a01 + b01 * a11));
  m.set(phi_10, where, Real(b10 * a00 + b11 * a10));
  m.set(phi_11, where, Real(b10 * a01 + b11 * a11));
  m.set(det, where, Real(m[det] * (b00 * b11 - b01 * b10)));
}

/// A flight begins at (x, v) with the forcing's phase (c, s).
template <class Real>
void depart(Memory<Real>& m, const Mask<Real>& where, const Real& x, const Real& v, const Real& c, const Real& s,
            bool from_barrier) {
  const Real w = m[frequency], k = m[stiffness], b = m[damping];
  const Real d = x - (m[cosine] * c + m[sine] * s + m[offset]), e = v - w * (m[sine] * c - m[cosine] * s);
  // |d''| <= sqrt(d'''^2 + k d''^2)/sqrt(k): an energy, which only decays; it is below the sum of the two.
  const Real d2 = -2.0 * b * e - k * d, d3 = -2.0 * b * d2 - k * e, h = m[march_step];
  const Real bend = abs(d2) + abs(d3) * m[inverse_root_k] + m[forced2];
  m.set(start_p, where, d);
  m.set(start_q, where, Real((e + b * d) * m[inverse_rate]));
  m.set(spiral_c, where, Real(1.0));
  m.set(spiral_s, where, Real(0.0));
  m.set(phase_c, where, c);
  m.set(phase_s, where, s);
  m.set(flown, where, Real(0.0));
  m.set(marched, where, Real(0.0));
  m.set(level, where, Real(1.0));
  m.set(tried, where, Real(0.0));
  m.set(cushion, where, Real(0.125 * bend * (h * h)));
  m.set(at_barrier, where, Real(from_barrier ? 1.0 : 0.0));
  m.assign(where, Task::marching);
}

/// A motion on the barrier leaves it with speed v < 0: a flight, unless it would be a short one.
template <class Real> void leave_barrier(Memory<Real>& m, const Mask<Real>& where, const Real& v, const Real& c, const Real& s) {
  const Real r = m[barrier], pressing = m[amplitude] * c + m[constant] - 2.0 * m[damping] * v - m[stiffness] * r;
  const Mask<Real> goes = where & (v < Real(-slowest_impact)) & (Real(-2.0 * v) > shortest_flight * pressing);
  depart(m, goes, r, v, c, s, true);
  m.assign(where & !goes, Task::given_up);
}

/// Ends the flights of all lanes whose task is Task::crossing, and gives (as masks) those that reached the barrier, at speed `v`
/// and phase (c, s), and those that came to the end of the period, at (x, v).
template <class Real> struct Landing {
  Mask<Real> at_barrier, at_end;
  Real x, v, c, s;
};
template <class Real, bool Tangent> Landing<Real> land(Memory<Real>& m) {
  const Mask<Real> ending = m.is(Task::crossing);
  const FlightEnd<Real> end = flight_end(m);
  const Real P = end.E * m[start_p] + end.F * m[start_q], Q = end.E * m[start_q] - end.F * m[start_p], w = m[frequency];
  const Real x = P + (m[cosine] * end.c + m[sine] * end.s) + m[offset];
  const Real v = (m[rate] * Q - m[damping] * P) + w * (m[sine] * end.c - m[cosine] * end.s);
  const Real duration = m[flown] + end.h, b = m[damping], k = m[stiffness];
  const Mask<Real> short_hop = (m[at_barrier] > Real(0.5)) & (duration < Real(shortest_flight));
  const Mask<Real> good = end.at_barrier & (v > Real(slowest_impact)) & !short_hop;
  const Mask<Real> flown_out = good | end.at_end;
  m.set(rest, good, Real(m[rest] - end.h));
  m.set(divergence, flown_out, Real(m[divergence] - 2.0 * b * duration));
  if constexpr (Tangent) {
    const Real S = end.F * m[inverse_rate];
    compose(m, flown_out, Real(end.E + b * S), S, Real(-k * S), Real(end.E - b * S));
  }
  m.assign(ending & !flown_out, Task::given_up);
  return {good, end.at_end, x, v, end.c, end.s};
}

}  // namespace graze::lanes
