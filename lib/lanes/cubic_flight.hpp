// SPDX-License-Identifier: GPL-3.0-or-later
// CubicFlight: flights of a cantilever (beta x^3) in lanes, by Taylor series in steps as in cubic_flow.hpp. On every step the
// Bernstein coefficients of the series up to degree 8, with a bound of the remaining terms, show that the barrier is not
// reached or that the speed stays positive; if neither, the step is halved. A crossing is the root of the whole series.
#pragma once

#include <graze/lib/lanes/crossing.hpp>
#include <graze/lib/lanes/flight_series.hpp>
#include <graze/lib/lanes/root_in_step.hpp>
#include <graze/lib/lanes/rough_root.hpp>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Number of halvings of a step after which the motion is too close to a tangency for the lanes.
inline constexpr int most_halvings = 6;

template <class Number, bool WithTangent, std::size_t Order> struct CubicFlight {
  using Real = Number;
  using Series = FlightSeries<Real, WithTangent, Order>;
  static constexpr std::size_t order = Order;
  static constexpr bool tangent = WithTangent, cubic = true;

  static void begin_period(Memory<Real>& m, const Mask<Real>& where, const Real& x, const Real& v) {
    begin(m, where, Real(m[side] * x - m[barrier]), Real(m[side] * v), Real(1.0), Real(0.0));
    m.set(rest, where, m[period]);
    m.set(off_barrier, where, Real(0.0));
  }

  static void leave_barrier(Memory<Real>& m, const Mask<Real>& where, const Real& v, const Real& c, const Real& s) {
    const Real pressing = m[amplitude] * c + m[constant] - 2.0 * m[damping] * v - spring_at_barrier(m);
    const Mask<Real> goes = where & (-1.0 * v > m[slowest_impact]) & (Real(-2.0 * v) > m[shortest_flight] * pressing);
    begin(m, goes, Real(0.0), v, c, s);
    m.set(off_barrier, goes, Real(1.0));
    m.assign(and_not(where, goes), Task::given_up);
  }

  static Real spring_at_barrier(const Memory<Real>& m) {
    const Real r = m[barrier];
    return r * (m[stiffness] + m[lanes::cubic] * (r * r));
  }

  /// One step of every lane in flight. Returns the lanes that land on the barrier.
  static Landing<Real> step(Memory<Real>& m, const Job& job, Task) {
    const Mask<Real> flying = m.is(Task::flight);
    const FlightLaw<Real> law = law_of(m);
    const FlightState<Real> z = state_of(m);
    const Series series(law, z);
    const Real left = m[rest];
    Real last, before;
    series.size(law, last, before);
    Real h = trusted(last, before, 0.25 * job.tolerance);
    h = select(h >= left * (1.0 - 1e-12), left, h);
    Mask<Real> below = stays_below(series, z.gap, h), rising = below;
    for (int halvings = 0; any(and_not(flying, below)); ++halvings) {
      rising = keeps_rising(series, h);
      const Mask<Real> unsure = and_not(flying, below | rising);
      if (!any(unsure) || halvings == most_halvings) break;
      h = select(unsure, Real(0.5 * h), h);
      below = stays_below(series, z.gap, h);
    }
    const Mask<Real> from_barrier = (m[off_barrier] > Real(0.5)) & (m[flown] == Real(0.0));
    const Mask<Real> fine = flying & (from_barrier | (z.gap < -too_close * (1.0 + abs(law.r)))) & (below | rising) &
                            (Real(last + before) < Real(1e300)) & (m[steps] < Real(static_cast<double>(job.max_steps)));
    Mask<Real> crosses = and_not(fine, below);
    if (any(crosses)) {
      const Real reached = series.gap(h);
      crosses = crosses & (reached >= Real(0.0));
      h = root_in_step([&](const Real& trial) { return std::pair<Real, Real>(series.gap(trial), series.speed(trial)); }, h,
                       select(crosses, parabola_root(z.gap, z.v, h, reached), h), crosses);
    }
    const FlightState<Real> next = series.at(h);
    const Mask<Real> moves = and_not(fine, crosses);
    set(m, moves, next);
    const Real duration = m[flown] + h;
    m.set(flown, moves, duration);
    m.set(rest, fine, Real(left - h));
    m.set(steps, moves, Real(m[steps] + 1.0));
    m.assign(moves & (h >= left), Task::period_end);
    m.assign(and_not(flying, fine), Task::given_up);
    if (!any(crosses)) return {crosses, next.v, next.c, next.s};
    const Mask<Real> short_hop = (m[off_barrier] > Real(0.5)) & (duration < m[shortest_flight]);
    const Mask<Real> lands = and_not(crosses & (next.v > m[slowest_impact]), short_hop);
    end_flight(m, lands, next.Phi, duration);
    m.assign(and_not(crosses, lands), Task::given_up);
    return {lands, next.v, next.c, next.s};
  }

  static std::pair<Real, Real> end(Memory<Real>& m, const Mask<Real>& where) {
    const Real x = m[barrier] + m[gap], v = m[gap_speed];
    end_flight(m, where, state_of(m).Phi, m[flown]);
    return {m[side] * x, m[side] * v};
  }

 private:
  static FlightLaw<Real> law_of(const Memory<Real>& m) {
    return {2.0 * m[damping], m[stiffness], m[lanes::cubic], m[amplitude], m[frequency], m[constant], m[barrier]};
  }
  static FlightState<Real> state_of(const Memory<Real>& m) {
    return {m[gap], m[gap_speed], m[phase_c], m[phase_s], {m[flight_00], m[flight_01], m[flight_10], m[flight_11]}};
  }
  static void set(Memory<Real>& m, const Mask<Real>& where, const FlightState<Real>& z) {
    m.set(gap, where, z.gap);
    m.set(gap_speed, where, z.v);
    m.set(phase_c, where, z.c);
    m.set(phase_s, where, z.s);
    if constexpr (tangent) {
      m.set(flight_00, where, z.Phi[0]);
      m.set(flight_01, where, z.Phi[1]);
      m.set(flight_10, where, z.Phi[2]);
      m.set(flight_11, where, z.Phi[3]);
    }
  }
  static void begin(Memory<Real>& m, const Mask<Real>& where, const Real& gap, const Real& v, const Real& c, const Real& s) {
    set(m, where, {gap, v, c, s, {Real(1.0), Real(0.0), Real(0.0), Real(1.0)}});
    m.set(flown, where, Real(0.0));
    m.set(steps, where, Real(0.0));
    m.assign(where, Task::flight);
  }
  static void end_flight(Memory<Real>& m, const Mask<Real>& where, const Real (&Phi)[4], const Real& duration) {
    if constexpr (tangent) {
      m.set(divergence, where, Real(m[divergence] - 2.0 * m[damping] * duration));
      compose(m, where, Phi[0], Phi[1], Phi[2], Phi[3]);
    }
  }

  /// The longest step in which neither of the last two terms is more than `allowed`.
  static Real trusted(const Real& last, const Real& before, double allowed) {
    return least(rough_root<Series::order>(allowed, last), rough_root<Series::order - 1>(allowed, before));
  }

  static constexpr std::size_t degree = 8;
  /// Whether the gap is <= 0 on a step and < 0 at its end.
  static Mask<Real> stays_below(const Series& series, const Real& at_start, const Real& h) {
    constexpr double inverse_binomial[] = {1.0,        1.0 / 8.0,  1.0 / 28.0, 1.0 / 56.0, 1.0 / 70.0,
                                           1.0 / 56.0, 1.0 / 28.0, 1.0 / 8.0,  1.0};
    const auto& a = series.position();
    Real b[degree + 1], power = h;
    b[0] = at_start;
#pragma GCC unroll 8
    for (std::size_t k = 1; k <= degree; ++k, power = power * h) b[k] = (inverse_binomial[k] * a[k]) * power;
    Real left_out = abs(a[Series::order]);
#pragma GCC unroll 16
    for (std::size_t k = Series::order - 1; k > degree; --k) left_out = madd(h, left_out, abs(a[k]));
    b[degree] = madd(power, left_out, b[degree]);
    return below_zero(b);
  }
  /// Whether the speed is >= 0 on a step and > 0 at its end.
  static Mask<Real> keeps_rising(const Series& series, const Real& h) {
    constexpr double weight[] = {-1.0,        -2.0 / 7.0,  -3.0 / 21.0, -4.0 / 35.0,
                                 -5.0 / 35.0, -6.0 / 21.0, -7.0 / 7.0,  -8.0};  // (i + 1)/binomial(7, i)
    const auto& a = series.position();
    Real b[degree], power = Real(1.0);
#pragma GCC unroll 8
    for (std::size_t i = 0; i < degree; ++i, power = power * h) b[i] = (weight[i] * a[i + 1]) * power;
    Real left_out = static_cast<double>(Series::order) * abs(a[Series::order]);
#pragma GCC unroll 16
    for (std::size_t k = Series::order - 1; k > degree; --k)
      left_out = madd(h, left_out, Real(static_cast<double>(k) * abs(a[k])));
    b[degree - 1] = madd(power, left_out, b[degree - 1]);
    return below_zero(b);
  }
};

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
