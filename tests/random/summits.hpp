// SPDX-License-Identifier: GPL-3.0-or-later
// Interior maxima of an orbit's flights: the orbit is admissible if all of them lie below the barrier. Each flight is sampled
// densely for changes of sign of x' (the forced part and the transient are carried on by rotations), and each change is polished
// by Newton's method on x' = 0. A maximum beyond the barrier is the only way through it, for a flight ends moving upwards.
#pragma once

#include "impact_equations.hpp"

#include <vector>

namespace graze::reference {

/// Sampling distance in time, of the faster of the two motions.
inline constexpr double summit_sampling = 0.03;

template <class Real> struct Summit {
  int leg = 0;
  Real time{};    ///< after the leg's start
  Real height{};  ///< over the barrier
};

/// Newton's method on x' = 0 from a time nearby.
template <class Real> Summit<Real> polished_summit(const Frame& frame, const Values<Real>& y, int i, Real time) {
  const Parameters<Real> q = frame.at(y[frame.size()]);
  const Leg<Real> here = leg(frame, y, i);
  for (int k = 0; k < 8; ++k) {
    const Motion<Real> at = flight(q, here.phase, here.start, time);
    const Real step = at.v / acceleration(q, here.phase + q[ETA] * time, at);
    time -= step;
    if (magnitude(step) < converged_step(Real(0))) break;
  }
  return {i, time, flight(q, here.phase, here.start, time).x - q[R]};
}

/// By decreasing height.
inline std::vector<Summit<double>> summits(const Frame& frame, const Values<double>& y) {
  const Parameters<double> q = frame.at(y[frame.size()]);
  std::vector<Summit<double>> out;
  for (int i = 0; i < frame.impacts; ++i) {
    const Leg<double> here = leg(frame, y, i);
    const int steps = std::max(20, static_cast<int>(here.duration * std::max(1.0, q[ETA]) / summit_sampling));
    const double h = here.duration / steps;
    const Transition<double> on = transition(q, h);
    const double c = std::cos(q[ETA] * h), s = std::sin(q[ETA] * h);
    Motion<double> forced = impactless(q, here.phase), rest{here.start.x - forced.x, here.start.v - forced.v};
    double v = here.start.v;
    for (int k = 1; k < steps; ++k) {
      forced = {c * forced.x + s * forced.v / q[ETA], c * forced.v - s * forced.x * q[ETA]};
      rest = on * rest;
      const double next = forced.v + rest.v;
      if (v > 0.0 && next <= 0.0) {
        Summit<double> found = polished_summit(frame, y, i, (k - next / (next - v)) * h);
        if (!(found.time > (k - 2) * h && found.time < (k + 1) * h)) found = {i, k * h, forced.x + rest.x - q[R]};
        out.push_back(found);
      }
      v = next;
    }
  }
  std::sort(out.begin(), out.end(), [](const auto& one, const auto& other) { return one.height > other.height; });
  return out;
}

/// Height of the highest summit; far below the barrier if there is none.
inline double gap(const Frame& frame, const Values<double>& y) {
  const std::vector<Summit<double>> all = summits(frame, y);
  return all.empty() ? -1.0 : all.front().height;
}

/// Acceleration just after the impact that presses most: with k_r = 0 the mass sticks where it is not negative.
inline double pressing(const Frame& frame, const Values<double>& y) {
  const Parameters<double> q = frame.at(y[frame.size()]);
  double most = -1e300;
  for (int i = 0; i < frame.impacts; ++i)
    most = std::max(most, acceleration(q, y[2 * static_cast<std::size_t>(i)], Motion<double>{q[R], 0.0}));
  return most;
}

inline bool sticks(const Frame& frame, const Values<double>& y) {
  return frame.at(y[frame.size()])[K_R] == 0.0 && pressing(frame, y) >= 0.0;
}

inline bool admissible(const Frame& frame, const Values<double>& y) {
  for (int i = 0; i < frame.impacts; ++i)
    if (!(y[2 * static_cast<std::size_t>(i) + 1] > 0.0)) return false;
  return gap(frame, y) < 0.0 && !sticks(frame, y);
}

}  // namespace graze::reference
