// SPDX-License-Identifier: GPL-3.0-or-later
// Memory: where the motions in the lanes stand, number by number, and how the lanes are told apart.
#pragma once

#include <graze/lib/lanes/job.hpp>
#include <graze/lib/lanes/real.hpp>

namespace graze::lanes {

/// What a lane is at; `marching` and `flight`: in flight, far from the barrier and perhaps not.
enum class Task { idle, marching, flight, crossing, contact, given_up };

enum Field : std::size_t {
  // A flight: deviation from the particular solution when it began, as e^(-b s) (P cos(q s) + Q sin(q s)); the spiral
  // e^(-b s) (cos(q s), sin(q s)) since then; cosine and sine of the forcing's phase.
  start_p,
  start_q,
  spiral_c,
  spiral_s,
  phase_c,
  phase_s,
  flown,         ///< time since it began
  marched,       ///< steps of the march that are not in it yet
  rest,          ///< time left of the forcing period
  level,         ///< of the step, see `levels`
  tried,         ///< 1: the step before was too long
  cushion,       ///< how far x may rise above a chord of the marching step
  at_barrier,    ///< 1: it began there (where the gap is zero, not what rounding says)
  reach,         ///< how far the certificate of a crossing holds
  may_cross,     ///< 1: the speed is positive as far as that
  contact_time,  ///< a contact: as HertzState
  contact_divergence,
  depth,
  speed,
  dx_0,
  dx_1,
  q_0,
  q_1,
  step,
  phi_00,  ///< the period's tangent so far, before the present flight or contact
  phi_01,
  phi_10,
  phi_11,
  det,
  divergence,
  fields
};

template <class Real> struct Memory {
  static constexpr std::size_t W = width<Real>;
  alignas(64) double coefficient[coefficients][W];
  alignas(64) double field[fields][W];
  alignas(64) double task[W];
  std::size_t motion[W], period[W];
  const ContactPieces* table[W];
  SpeedsMet* met[W];
  int impacts[W];

  Real operator[](Field f) const { return take<Real>(field[f]); }
  Real operator[](Coefficient c) const { return take<Real>(coefficient[c]); }
  void set(Field f, const Real& value) { put(field[f], value); }
  template <class Mask> void set(Field f, const Mask& mask, const Real& value) {
    put(field[f], Real(select(mask, value, take<Real>(field[f]))));
  }
  auto is(Task t) const { return take<Real>(task) == Real(static_cast<double>(t)); }
  bool is(std::size_t lane, Task t) const { return task[lane] == static_cast<double>(t); }
  template <class Mask> void assign(const Mask& mask, Task t) {
    put(task, Real(select(mask, Real(static_cast<double>(t)), take<Real>(task))));
  }
  void assign(std::size_t lane, Task t) { task[lane] = static_cast<double>(t); }
};

/// A motion in free flight at an instant: its transient and its forced part, and their derivatives.
template <class Real> struct Point {
  Real x, v, a, j, x4, x5;
  Real bound6;  ///< of the sixth derivative from here on
};

/// From the transient's (P, Q) and the forcing's phase.
template <class Real>
[[gnu::always_inline]] inline Point<Real> point(const Memory<Real>& m, const Real& P, const Real& Q, const Real& c,
                                                const Real& s) {
  const Real b2 = 2.0 * m[damping], k = m[stiffness], w = m[frequency], w2 = w * w;
  const Real d0 = P, d1 = m[rate] * Q - m[damping] * P, d2 = -b2 * d1 - k * d0, d3 = -b2 * d2 - k * d1, d4 = -b2 * d3 - k * d2,
             d5 = -b2 * d4 - k * d3, d6 = -b2 * d5 - k * d4;
  const Real f0 = m[cosine] * c + m[sine] * s, f1 = w * (m[sine] * c - m[cosine] * s), f2 = -w2 * f0, f3 = -w2 * f1,
             f4 = -w2 * f2, f5 = -w2 * f3;
  return {d0 + f0 + m[offset], d1 + f1, d2 + f2, d3 + f3, d4 + f4, d5 + f5, abs(d6) + abs(d5) * m[root_k] + m[forced6]};
}

}  // namespace graze::lanes
