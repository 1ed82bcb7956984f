// SPDX-License-Identifier: GPL-3.0-or-later
#include "events.hpp"
#include "family.hpp"

namespace graze::reference {

namespace {

struct Passage {
  double time = 0.0;
  std::size_t stop = 0;
};

/// First passage of a stop within time `most` on a flight from `at` (just after an impact, or at phase 0); nothing if there is
/// none. A passage between two samples is detected by a maximum beyond the stop.
std::optional<Passage> passage(const Linear<double>& system, double phase, const Point<double>& at, double most) {
  const double h = summit_sampling / fastest(system);
  const Square<double> on = transition(system, h);
  Point<double> last = at, rest = plus(at, -1.0, impactless(system, phase));
  for (double s = 0.0; s < most;) {
    const double next = std::min(most, s + h);
    rest = on * rest;
    const Point<double> now =
        next < s + h ? flight(system, phase, at, next) : plus(impactless(system, phase + system.q[ETA] * next), 1.0, rest);
    std::optional<Passage> first;
    for (std::size_t j = 0; j < system.stops.size(); ++j) {
      const Stop<double>& stop = system.stops[j];
      double high = next, height = stop.height(now);
      if (stop.speed(last) > 0.0 && stop.speed(now) <= 0.0) {
        double low = s, up = next;
        for (int k = 0; k < 60; ++k) {
          const double middle = 0.5 * (low + up);
          (stop.speed(flight(system, phase, at, middle)) > 0.0 ? low : up) = middle;
        }
        const double top = stop.height(flight(system, phase, at, low));
        if (top > height) {
          high = low;
          height = top;
        }
      }
      if (!(height > 0.0)) continue;
      double low = s, up = high;
      for (int k = 0; k < 60; ++k) {
        const double middle = 0.5 * (low + up);
        (stop.height(flight(system, phase, at, middle)) < 0.0 ? low : up) = middle;
      }
      if (!first || up < first->time) first = {up, j};
    }
    if (first) return first;
    last = now;
    s = next;
  }
  return std::nullopt;
}

/// Carries z at `phase` over one period. Returns the number of impacts, which are added to `orbit`; nothing if there are more
/// than `most`.
std::optional<int> one_period(const Linear<double>& system, double phase, Point<double>& z, int most, Orbit* orbit = nullptr) {
  const double eta = system.q[ETA];
  double left = 2.0 * pi<double>() / eta;
  int impacts = 0;
  while (const std::optional<Passage> next = passage(system, phase, z, left)) {
    if (++impacts > most) return std::nullopt;
    const Stop<double>& stop = system.stops[next->stop];
    z = flight(system, phase, z, next->time);
    phase += eta * next->time;
    left -= next->time;
    if (orbit) {
      const Values<double> block = block_of(system, stop, phase, z);
      orbit->y.insert(orbit->y.end(), block.begin(), block.end());
      orbit->frame.stops.push_back(static_cast<int>(next->stop));
      if (!(block[1] > 0.0)) return std::nullopt;
    }
    z = stop.rebound(z);
  }
  z = flight(system, phase, z, left);
  return impacts;
}

/// Half of a symmetric orbit; nothing if the orbit is not symmetric.
std::optional<Orbit> half_period_orbit(const Orbit& whole) {
  constexpr double same = 1e-6;
  const Frame& frame = whole.frame;
  if (frame.model != Model::equal_stops || frame.periods % 2 == 0 || frame.legs() % 2 != 0) return std::nullopt;
  Orbit out = whole;
  const std::size_t n = frame.size() / 2;
  for (std::size_t i = 0; i < frame.legs() / 2; ++i)
    if (frame.stops[i] == frame.stops[i + frame.legs() / 2]) return std::nullopt;
  for (std::size_t k = 0; k < n; ++k) {
    const double shift = k % frame.block() == 0 ? 0.5 * frame.turn<double>() : 0.0;
    if (std::fabs(whole.y[k + n] - whole.y[k] - shift) > same * (1.0 + std::fabs(whole.y[k]))) return std::nullopt;
  }
  out.frame.stops.resize(frame.legs() / 2);
  out.frame.half = true;
  out.y.resize(n);
  out.y.push_back(whole.y.back());
  const std::optional<Values<double>> y = corrected(out.frame, out.y, fixed_parameter(out.frame, out.y.back()));
  if (!y) return std::nullopt;
  out.y = *y;
  return out;
}

}  // namespace

std::optional<Orbit> events_of(Frame frame, int impacts, double p, const std::vector<State>& states, double tolerance) {
  const Linear<double> system = frame.system(p);
  if (static_cast<int>(states.size()) != frame.periods) return std::nullopt;
  frame.half = false;
  frame.stops.clear();
  Orbit out{frame, {}};
  for (std::size_t k = 0; k < states.size(); ++k) {
    Point<double> z = point_of(system, states[k]);
    if (!one_period(system, 2.0 * pi<double>() * static_cast<double>(k), z, impacts, &out)) return std::nullopt;
  }
  if (out.frame.impacts() != impacts) return std::nullopt;
  out.y.push_back(p);
  const std::optional<Values<double>> y = corrected(out.frame, out.y, fixed_parameter(out.frame, p));
  if (!y || !admissible(out.frame, *y) || apart(states_of(out.frame, *y), states) > tolerance) return std::nullopt;
  out.y = *y;
  return half_period_orbit(out).value_or(out);
}

std::optional<Orbit> settled(const Frame& frame, double p, int most_periods, int most_impacts) {
  constexpr int transient = 400;
  constexpr double same = 1e-7;
  const Linear<double> system = frame.system(p);
  Point<double> z{};
  const Stop<double>& stop = system.stops.front();
  z[stop.bound()] = std::min(0.0, stop.wall) / stop.row[stop.bound()];
  for (int k = 0; k < transient; ++k)
    if (!one_period(system, 0.0, z, most_impacts)) return std::nullopt;
  std::vector<State> states = {state_of(system, z)};
  int found = 0;
  Frame own = frame;
  own.periods = 0;
  while (own.periods < most_periods) {
    const std::optional<int> impacts = one_period(system, 0.0, z, most_impacts);
    if (!impacts) return std::nullopt;
    found += *impacts;
    ++own.periods;
    const State state = state_of(system, z);
    if (apart({state}, {states.front()}) < same) {
      if (found == 0 || found > most_impacts) return std::nullopt;
      const std::optional<Orbit> out = events_of(own, found, p, states, 1e-4);
      if (!out) return std::nullopt;
      // A slowly attracting orbit of a lower period can close more accurately after several of its periods.
      const std::vector<State> exact = states_of(out->frame, out->y);
      for (std::size_t shift = 1; shift < exact.size(); ++shift) {
        double far = 0.0;
        for (std::size_t k = 0; k < exact.size(); ++k)
          far = std::max(far, apart({exact[k]}, {exact[(k + shift) % exact.size()]}));
        if (far < 1e3 * same) return std::nullopt;
      }
      return out;
    }
    states.push_back(state);
  }
  return std::nullopt;
}

}  // namespace graze::reference
