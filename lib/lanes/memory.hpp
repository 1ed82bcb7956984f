// SPDX-License-Identifier: GPL-3.0-or-later
// Memory: the state of the motions in the lanes, one row of numbers for each quantity, and the task of each lane.
#pragma once

#include <graze/lib/lanes/job.hpp>
#include <graze/lib/lanes/real.hpp>

#include <algorithm>
#include <bit>
#include <cstdint>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// The task of a lane. In flight: `marching` on the grid; `flight` near the barrier (or by series); `crossing` in a step that
/// ends at the barrier; `period_end`.
enum class Task { idle, marching, flight, crossing, period_end, contact, given_up };

enum Field : std::size_t {
  // A flight: deviation from the particular solution, which after a time s is P cos(q s) + Q sin(q s) times the decay; the
  // spiral e^(-b t) (cos(q t), sin(q t)) since the flight or the period began; cosine and sine of the forcing's phase.
  transient_p,
  transient_q,
  spiral_c,
  spiral_s,
  phase_c,
  phase_s,
  flown,       ///< time since the flight or the period began
  next_point,  ///< of the grid: its number, and the time up to it (`marching`: the motion is there)
  ahead,
  trial,        ///< length of the next step, at most up to that point
  tried,        ///< 1: the step before was too long
  ceiling,      ///< if x is below it at both ends of a cell, x does not reach the barrier in between
  off_barrier,  ///< 1: the flight began on the barrier, with a gap of exactly zero in spite of rounding
  rest,         ///< time left of the forcing period, at the end of a flight and during a contact
  gap,  ///< a flight with beta x^3: distance from the barrier (negative), speed, tangent since the flight or the period began
  gap_speed,
  flight_00,
  flight_01,
  flight_10,
  flight_11,
  contact_time,  ///< a contact: as ContactState
  contact_divergence,
  depth,
  speed,
  z_0,
  z_1,
  p_0,
  p_1,
  step,
  steps,   ///< number of steps so far
  phi_00,  ///< the period's tangent so far, before the present flight or contact
  phi_01,
  phi_10,
  phi_11,
  det,
  divergence,
  impact_count,  ///< of the period so far
  ended,         ///< number of periods of the motion that have ended
  next_stored,   ///< number of the next period to be stored wherever it ends; 0: every one
  begun_at,      ///< position and speed at the start of the period, of observed motions
  begun_with,
  fields
};

template <class Real> struct Memory {
  static constexpr std::size_t W = width<Real>;
  static_assert(W <= 8, "a byte for each task");
  alignas(64) double coefficient[coefficients][W];
  alignas(64) double field[fields][W];
  std::uint64_t tasks = 0;  ///< byte t: bits of the lanes at Task t
  std::size_t motion[W];
  const Coefficients* coefficients_of[W];  ///< source of `coefficient`
  const Grid* grid[W];
  const ContactPieces* table[W];
  SpeedHistogram* met[W];

  /// All lanes are idle. (Idle lanes take part in the arithmetic, with harmless numbers.)
  Memory() {
    for (auto& row : coefficient) std::fill_n(row, W, 1.0);
    for (auto& row : field) std::fill_n(row, W, 0.0);
    for (std::size_t lane = 0; lane < W; ++lane) {
      assign(lane, Task::idle);
      motion[lane] = 0;
      coefficients_of[lane] = nullptr;
      grid[lane] = nullptr;
      table[lane] = nullptr;
      met[lane] = nullptr;
    }
  }

  Real operator[](Field f) const { return take<Real>(field[f]); }
  Real operator[](Coefficient c) const { return take<Real>(coefficient[c]); }
  void set(Field f, const Real& value) { put(field[f], value); }
  template <class Mask> void set(Field f, const Mask& mask, const Real& value) {
    if constexpr (W == 1) {  // one lane: a branch, which the processor predicts
      if (mask) field[f][0] = value;
    } else {
      put(field[f], Real(select(mask, value, take<Real>(field[f]))));
    }
  }
  /// The lanes at a task: as bits, their number, as a mask.
  unsigned at(Task t) const { return static_cast<unsigned>(tasks >> 8 * static_cast<unsigned>(t)) & 0xffU; }
  int count(Task t) const { return std::popcount(at(t)); }
  auto is(Task t) const { return mask_of<Real>(at(t)); }
  bool is(std::size_t lane, Task t) const { return (at(t) >> lane & 1U) != 0; }
  Task task(std::size_t lane) const {
    constexpr std::uint64_t each_byte = 0x0101010101010101U;
    return static_cast<Task>(std::countr_zero(tasks >> lane & each_byte) / 8);
  }
  void assign_bits(unsigned lanes, Task t) {
    constexpr std::uint64_t each_byte = 0x0101010101010101U;
    tasks = (tasks & ~(lanes * each_byte)) | std::uint64_t{lanes} << 8 * static_cast<unsigned>(t);
  }
  template <class Mask> void assign(const Mask& mask, Task t) { assign_bits(bits(mask), t); }
  void assign(std::size_t lane, Task t) { assign_bits(1U << lane, t); }
  /// Sets the tangent to the identity at the start of a period.
  template <class Mask> void begin_tangent(const Mask& where) {
    for (const Field one : {phi_00, phi_11, det}) set(one, where, Real(1.0));
    for (const Field zero : {phi_01, phi_10, divergence}) set(zero, where, Real(0.0));
  }
  /// Counts the impacts of lanes that have reached the barrier from outside; lanes that leave a contact do not count. Gives up
  /// the lanes with too many impacts and returns the others.
  template <class Mask> Mask count_impacts(const Mask& where) {
    const Real count = (*this)[impact_count] + select((*this)[side] > Real(0.0), Real(1.0), Real(0.0));
    set(impact_count, where, count);
    const Mask good = where & (count <= Real(static_cast<double>(most_impacts)));
    assign(and_not(where, good), Task::given_up);
    return good;
  }
  /// Loads a motion's coefficients into a lane: those of its flight, or those of -x in contact.
  void load(std::size_t lane, const Motion& of_motion, bool pressed) {
    grid[lane] = pressed ? of_motion.pressed_grid : of_motion.grid;
    const Coefficients* const of_side = pressed ? of_motion.pressed : of_motion.coefficients;
    if (coefficients_of[lane] == of_side) return;
    coefficients_of[lane] = of_side;
    for (std::size_t i = 0; i < coefficients; ++i) coefficient[i][lane] = (*of_side)[i];
  }
};

/// A motion in free flight at an instant: position, transient plus forced part, and its derivatives.
template <class Real> struct Point {
  Real x, v, a, j, x4, x5;
  Real bound6;  ///< bound of the sixth derivative from here on
};

/// The point from the transient's (P, Q) and the forcing's phase.
template <class Real>
[[gnu::always_inline]] inline Point<Real> point(const Memory<Real>& m, const Real& P, const Real& Q, const Real& c,
                                                const Real& s) {
  const Real minus_b2 = -2.0 * m[damping], k = m[stiffness], w = m[frequency], w2 = w * w;
  const Real d0 = P, d1 = wedge(m[rate], Q, m[damping], P), d2 = wedge(minus_b2, d1, k, d0), d3 = wedge(minus_b2, d2, k, d1),
             d4 = wedge(minus_b2, d3, k, d2), d5 = wedge(minus_b2, d4, k, d3), d6 = wedge(minus_b2, d5, k, d4);
  const Real f0 = dot(m[cosine], c, m[sine], s), f1 = w * wedge(m[sine], c, m[cosine], s), f2 = -w2 * f0, f3 = -w2 * f1,
             f4 = -w2 * f2, f5 = -w2 * f3;
  return {d0 + f0 + m[offset], d1 + f1, d2 + f2, d3 + f3, d4 + f4, d5 + f5, abs(d6) + abs(d5) * m[root_k] + m[forced6]};
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
