// SPDX-License-Identifier: GPL-3.0-or-later
// Interior maxima of the flights of an orbit towards each stop: the orbit is admissible if all of them lie below it. Each
// flight is sampled densely for sign changes of the speed towards a stop (the forced part by a rotation, the transient by its
// exponential), and Newton's method polishes each change. Every passage through a stop has a maximum beyond it: a flight ends
// with its motion towards the stop that it meets, and no system here can be at two stops at once.
#pragma once

#include "impact_equations.hpp"

#include <vector>

namespace graze::reference {

/// Sampling distance in time, for the faster of the two motions.
inline constexpr double summit_sampling = 0.03;

template <class Real> struct Summit {
  std::size_t leg = 0, stop = 0;
  Real time{};    ///< after the start of the leg
  Real height{};  ///< above the stop
};

/// Newton's method from a nearby time.
template <class Real> Summit<Real> polished_summit(const Frame& frame, const Values<Real>& y, const Summit<Real>& guess) {
  const Leg<Real> here = leg(frame, y, guess.leg);
  const Stop<Real>& stop = here.system.stops[guess.stop];
  Summit<Real> out = guess;
  for (int k = 0; k < 8; ++k) {
    const Point<Real> at = flight(here.system, here.phase, here.start, out.time);
    const Real step = stop.speed(at) / stop.speed(rate(here.system, here.phase + here.system.q[ETA] * out.time, at));
    out.time -= step;
    if (magnitude(step) < converged_step(Real(0))) break;
  }
  out.height = stop.height(flight(here.system, here.phase, here.start, out.time));
  return out;
}

/// By decreasing height.
inline std::vector<Summit<double>> summits(const Frame& frame, const Values<double>& y) {
  std::vector<Summit<double>> out;
  for (std::size_t i = 0; i < frame.legs(); ++i) {
    const Leg<double> here = leg(frame, y, i);
    const int steps = std::max(20, static_cast<int>(here.duration * fastest(here.system) / summit_sampling));
    const double h = here.duration / steps, c = std::cos(here.system.q[ETA] * h), s = std::sin(here.system.q[ETA] * h);
    const Square<double> on = transition(here.system, h);
    double along = std::cos(here.phase), across = std::sin(here.phase);
    Point<double> rest = plus(here.start, -1.0, impactless(here.system, here.phase)), last = here.start;
    for (int k = 1; k < steps; ++k) {
      const double turned = c * along - s * across;
      across = s * along + c * across;
      along = turned;
      rest = on * rest;
      const Point<double> now = plus(plus(rest, along, here.system.in_cos), across, here.system.in_sin);
      for (std::size_t j = 0; j < here.system.stops.size(); ++j) {
        const Stop<double>& stop = here.system.stops[j];
        const double v = stop.speed(last), next = stop.speed(now);
        if (!(v > 0.0 && next <= 0.0)) continue;
        Summit<double> found = polished_summit(frame, y, {i, j, (k - next / (next - v)) * h, 0.0});
        if (!(found.time > (k - 2) * h && found.time < (k + 1) * h)) found = {i, j, k * h, stop.height(now)};
        out.push_back(found);
      }
      last = now;
    }
  }
  std::sort(out.begin(), out.end(), [](const auto& one, const auto& other) { return one.height > other.height; });
  return out;
}

/// Height of the highest summit; far below the stops if there is none.
inline double gap(const Frame& frame, const Values<double>& y) {
  const std::vector<Summit<double>> all = summits(frame, y);
  return all.empty() ? -1.0 : all.front().height;
}

/// Acceleration just after the impact with the largest contact force: without rebound the mass sticks where it is not
/// negative.
inline double pressing(const Frame& frame, const Values<double>& y) {
  double most = -1e300;
  for (std::size_t i = 0; i < frame.legs(); ++i) {
    const Leg<double> here = leg(frame, y, i);
    if (here.from.restitution == 0.0) most = std::max(most, here.from.speed(rate(here.system, here.phase, here.start)));
  }
  return most;
}

inline bool sticks(const Frame& frame, const Values<double>& y) { return pressing(frame, y) >= 0.0; }

inline bool admissible(const Frame& frame, const Values<double>& y) {
  for (std::size_t i = 0; i < frame.legs(); ++i)
    if (!(y[frame.block() * i + 1] > 0.0)) return false;
  return gap(frame, y) < 0.0 && !sticks(frame, y);
}

}  // namespace graze::reference
