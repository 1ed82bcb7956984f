// SPDX-License-Identifier: GPL-3.0-or-later
#include "events.hpp"
#include "family.hpp"

namespace graze::reference {

namespace {

/// First passage of the barrier within `most` of a flight from `at` (just after an impact, or at phase 0); nothing if none.
/// A passage between two samples shows itself by a maximum beyond the barrier.
std::optional<double> passage(const Parameters<double>& q, double phase, const Motion<double>& at, double most) {
  const double h = summit_sampling / std::max(1.0, q[ETA]);
  Motion<double> last = at;
  for (double s = 0.0; s < most;) {
    const double next = std::min(most, s + h);
    const Motion<double> now = flight(q, phase, at, next);
    double high = next, height = now.x - q[R];
    if (last.v > 0.0 && now.v <= 0.0) {
      double low = s, up = next;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + up);
        (flight(q, phase, at, middle).v > 0.0 ? low : up) = middle;
      }
      const double top = flight(q, phase, at, low).x - q[R];
      if (top > height) {
        high = low;
        height = top;
      }
    }
    if (height > 0.0) {
      double low = s, up = high;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + up);
        (flight(q, phase, at, middle).x < q[R] ? low : up) = middle;
      }
      return up;
    }
    last = now;
    s = next;
  }
  return std::nullopt;
}

/// One period from phase 0: the state after it, and how many impacts it has; nothing if they are more than `most`.
std::optional<int> one_period(const Parameters<double>& q, State& state, int most) {
  Motion<double> at{state[0], state[1]};
  double phase = 0.0, left = 2.0 * pi<double>() / q[ETA];
  int impacts = 0;
  while (const std::optional<double> s = passage(q, phase, at, left)) {
    if (++impacts > most) return std::nullopt;
    phase += q[ETA] * *s;
    left -= *s;
    at = {q[R], -q[K_R] * flight(q, phase - q[ETA] * *s, at, *s).v};
  }
  at = flight(q, phase, at, left);
  state = {at.x, at.v};
  return impacts;
}

}  // namespace

std::optional<Values<double>> events_of(const Frame& frame, double p, const std::vector<State>& states, double tolerance) {
  const Parameters<double> q = frame.at(p);
  const double period = 2.0 * pi<double>() / q[ETA];
  if (static_cast<int>(states.size()) != frame.periods) return std::nullopt;
  Values<double> y;
  for (std::size_t k = 0; k < states.size(); ++k) {
    Motion<double> at{states[k][0], states[k][1]};
    double phase = 2.0 * pi<double>() * static_cast<double>(k), left = period;
    while (const std::optional<double> s = passage(q, phase, at, left)) {
      const Motion<double> hit = flight(q, phase, at, *s);
      if (!(hit.v > 0.0) || y.size() == frame.size()) return std::nullopt;
      phase += q[ETA] * *s;
      left -= *s;
      at = {q[R], -q[K_R] * hit.v};
      y.insert(y.end(), {phase, hit.v});
    }
  }
  if (y.size() != frame.size()) return std::nullopt;
  y.push_back(p);
  const std::optional<Values<double>> orbit = corrected(frame, y, fixed_parameter(frame, p));
  if (!orbit || !admissible(frame, *orbit) || apart(states_of(frame, *orbit), states) > tolerance) return std::nullopt;
  return orbit;
}

std::optional<Settled> settled(const Frame& frame, double p, int most_periods, int most_impacts) {
  constexpr int transient = 400;
  constexpr double same = 1e-7;
  const Parameters<double> q = frame.at(p);
  State state = {std::min(0.0, q[R]), 0.0};
  for (int k = 0; k < transient; ++k)
    if (!one_period(q, state, most_impacts)) return std::nullopt;
  std::vector<State> states = {state};
  Settled out{0, 0, {}};
  while (out.periods < most_periods) {
    const std::optional<int> impacts = one_period(q, state, most_impacts);
    if (!impacts) return std::nullopt;
    out.impacts += *impacts;
    ++out.periods;
    if (std::fabs(state[0] - states[0][0]) + std::fabs(state[1] - states[0][1]) < same) {
      if (out.impacts == 0 || out.impacts > most_impacts) return std::nullopt;
      Frame own = frame;
      own.periods = out.periods;
      own.impacts = out.impacts;
      const std::optional<Values<double>> y = events_of(own, p, states, 1e-4);
      if (!y) return std::nullopt;
      // Slowly approached, an orbit of a lower period comes back to itself more exactly after several.
      const std::vector<State> exact = states_of(own, *y);
      for (std::size_t shift = 1; shift < exact.size(); ++shift) {
        double far = 0.0;
        for (std::size_t k = 0; k < exact.size(); ++k)
          for (std::size_t c = 0; c < 2; ++c) far = std::max(far, std::fabs(exact[k][c] - exact[(k + shift) % exact.size()][c]));
        if (far < 1e3 * same) return std::nullopt;
      }
      out.y = *y;
      return out;
    }
    states.push_back(state);
  }
  return std::nullopt;
}

}  // namespace graze::reference
