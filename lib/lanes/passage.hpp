// SPDX-License-Identifier: GPL-3.0-or-later
// Contacts in lanes: an impact with a coefficient of restitution, entry into and exit from a linear elastic stop, and a step of
// a Hertz contact (the series of hertz_flow.hpp).
#pragma once

#include <graze/lib/lanes/contact_series.hpp>
#include <graze/lib/lanes/crossing.hpp>
#include <graze/lib/lanes/root_in_step.hpp>
#include <graze/lib/lanes/rough_root.hpp>
#include <graze/lib/lanes/wide_registers.hpp>

#include <cmath>
#include <utility>

namespace graze::lanes {
inline namespace GRAZE_ARITHMETIC {

/// Records the speeds of impacts and entries into contact (Motion::notes).
template <class Real> void record_impacts(const Memory<Real>& m, const Landing<Real>& landing, const Motion* motions) {
  alignas(64) double speed[width<Real>];
  put(speed, landing.v);
  for_each(landing.where, [&](std::size_t lane) {
    SpeedRecorder* const notes = motions[m.motion[lane]].notes;
    if (!notes || m.coefficient[side][lane] < 0.0) return;
    WideRegisters::leave();
    notes->add(*notes, speed[lane]);
  });
}

/// x'+ = -k_r x'-, with its saltation matrix [[-k_r, 0], [(a+ + k_r a-)/v, -k_r]].
template <class Flight, class Real> void rebound(Memory<Real>& m, const Landing<Real>& landing) {
  const Real k = m[restitution], v = landing.v, after = -k * v;
  if constexpr (Flight::tangent) {
    const Real pull = m[amplitude] * landing.c + m[constant] - Flight::spring_at_barrier(m);
    const Real a_minus = pull - 2.0 * m[damping] * v, a_plus = pull - 2.0 * m[damping] * after;
    compose(m, landing.where, Real(-k), Real(0.0), Real((a_plus + k * a_minus) / v), Real(-k));
  }
  Flight::leave_barrier(m, landing.where, after, landing.c, landing.s);
}

/// Begins or ends a contact with a linear elastic stop: state and field are continuous, so the saltation matrix is the
/// identity.
template <class Flight, class Real> void change_sides(Memory<Real>& m, const Landing<Real>& landing, const Motion* motions) {
  for_each(landing.where, [&](std::size_t lane) {
    const bool enters = m.coefficient[side][lane] > 0.0;
    m.load(lane, motions[m.motion[lane]], enters);
  });
  Flight::leave_barrier(m, landing.where, Real(-landing.v), landing.c, landing.s);
}

template <class Real> ContactLaw<Real> contact_law(const Memory<Real>& m) {
  const Real k_H = m[contact_stiffness];
  return {2.0 * m[damping], m[frequency], m[amplitude], m[barrier], k_H, k_H * m[contact_damping], m[lanes::cubic]};
}

/// Sets the tangent of the rest of a contact to the identity, in the columns (z, p).
template <class Real> void begin_columns(Memory<Real>& m, const Mask<Real>& where, const Real& half_damping) {
  m.set(z_0, where, Real(1.0));
  m.set(z_1, where, Real(0.0));
  m.set(p_0, where, half_damping);
  m.set(p_1, where, Real(1.0));
}

/// Begins a contact at depth y^2 and speed v.
template <class Real>
void touch(Memory<Real>& m, const Mask<Real>& where, const Real& y, const Real& v, const Real& c, const Real& s) {
  m.set(depth, where, y);
  m.set(speed, where, v);
  m.set(phase_c, where, c);
  m.set(phase_s, where, s);
  m.set(contact_time, where, Real(0.0));
  m.set(contact_divergence, where, Real(0.0));
  begin_columns(m, where, contact_law(m).half_damping(y));
  m.set(step, where, Real(0.0));
  m.set(steps, where, Real(0.0));
  m.assign(where, Task::contact);
}

/// Lanes whose contact ended, at the barrier or with the period, and their state and phase there.
template <class Real> struct ContactEnd {
  Mask<Real> at_barrier, at_end;
  Real y, v, c, s;
};

/// One step of every lane in contact, at the accuracy of the job.
template <class Flight, class Real, class Job> ContactEnd<Real> press(Memory<Real>& m, const Job& job, double ratio) {
  using Series = ContactSeries<Real, Flight::tangent, Flight::cubic, Flight::order>;
  const Mask<Real> pressed = m.is(Task::contact);
  const ContactLaw<Real> law = contact_law(m);
  const ContactState<Real> z{m[depth], m[speed], m[phase_c], m[phase_s], m[contact_time], m[contact_divergence],
                             m[z_0],   m[z_1],   m[p_0],     m[p_1]};
  const Series series(law, z);
  const Real spring = Flight::spring_at_barrier(m);
  // The square of the longest step, times the bound of the acceleration.
  constexpr double longest = 2.0 * detail::hertz_longest_step * detail::hertz_longest_step;
  const auto acceleration = [&](const Real& v, const Real& dt) {
    return largest(Real(abs(Real(law.xi * z.c - spring)) + law.b2 * abs(v) + abs(law.xi) * law.w * dt), Real(1e-12));
  };
  const Real v = abs(z.v), longest_here = sqrt(Real(longest / acceleration(v, Real(0.0))));
  Real h = m[step];
  h = select(h > Real(0.0), h, longest_here);
  Real last, before;
  series.size(last, before);
  const Real size = largest(last, Real(before * (ratio / h)));
  h = least(longest_here, rough_root<Series::order>(detail::hertz_last_term * job.tolerance, size));
  Real y_end = series.depth(h), v_end = series.speed(h), time_end = series.time(h);
  const Real meanwhile = acceleration(largest(v, Real(abs(v_end))), Real(abs(Real(time_end - z.time))));
  const Mask<Real> shorter = h * h * meanwhile > Real(longest);
  if (any(pressed & shorter)) {
    h = select(shorter, sqrt(Real(longest / meanwhile)), h);
    y_end = series.depth(h);
    v_end = series.speed(h);
    time_end = series.time(h);
  }
  const Real duration = m[rest];
  const Mask<Real> finite = abs(Real(y_end + v_end + time_end)) < Real(1e300);
  Mask<Real> surfaced = and_not(pressed & finite, y_end > Real(0.0)), late = pressed & finite & (time_end >= duration);
  Real s = h;
  if (any(surfaced | late)) {
    s = root_in_step([&](const Real& trial) { return std::pair<Real, Real>(-series.depth(trial), -0.5 * series.speed(trial)); },
                     h, select(surfaced, parabola_root(Real(-z.y), Real(-0.5 * z.v), h, Real(-y_end)), h), surfaced);
    const Real over = series.time(s) - duration;
    const Mask<Real> in_time = surfaced & (over <= Real(0.0));
    late = and_not(surfaced | late, in_time);
    surfaced = in_time;
    s = root_in_step([&](const Real& trial) { return std::pair<Real, Real>(series.time(trial) - duration, series.depth(trial)); },
                     s, select(late, parabola_root(Real(z.time - duration), z.y, s, over), s), late);
    // In the other lanes s = h, the whole step.
  }
  const ContactState<Real> next = series.at(s);
  m.set(step, pressed, h);
  m.set(steps, pressed, Real(m[steps] + 1.0));
  m.set(depth, pressed, next.y);
  m.set(speed, pressed, next.v);
  m.set(phase_c, pressed, next.c);
  m.set(phase_s, pressed, next.s);
  m.set(contact_time, pressed, next.time);
  m.set(contact_divergence, pressed, next.divergence);
  const Mask<Real> ended = surfaced | late;
  const Real y = select(surfaced, Real(0.0), next.y);
  // The tangent of the contact is composed into that of the period at the end of the contact, and before z and p overflow.
  const Mask<Real> taken_over = ended | (pressed & (next.divergence < Real(-40.0)));
  if constexpr (Flight::tangent) {
    m.set(z_0, pressed, next.z_0);
    m.set(z_1, pressed, next.z_1);
    m.set(p_0, pressed, next.p_0);
    m.set(p_1, pressed, next.p_1);
    if (any(taken_over)) {
      alignas(64) double shrunk[width<Real>] = {};
      put(shrunk, next.divergence);
      for_each(taken_over, [&](std::size_t lane) { shrunk[lane] = std::exp(0.5 * shrunk[lane]); });
      const Real scale = take<Real>(shrunk), p_of_z = law.half_damping(y);
      compose(m, taken_over, Real(scale * next.z_0), Real(scale * next.z_1), Real(scale * (next.p_0 - p_of_z * next.z_0)),
              Real(scale * (next.p_1 - p_of_z * next.z_1)));
      begin_columns(m, taken_over, p_of_z);
    }
  }
  m.set(divergence, taken_over, Real(m[divergence] + next.divergence));
  m.set(contact_divergence, taken_over, Real(0.0));
  m.set(rest, surfaced, Real(duration - next.time));
  const Mask<Real> endless = and_not(m[steps] >= Real(static_cast<double>(job.max_steps)), ended);
  m.assign(pressed & (endless | !finite), Task::given_up);
  return {surfaced, late, y, next.v, next.c, next.s};
}

}  // namespace GRAZE_ARITHMETIC
}  // namespace graze::lanes
