// SPDX-License-Identifier: GPL-3.0-or-later
// The equations of the baselines, written by hand for each law and inlined (nothing type-erased): the oscillator
//     x'' + 2 b x' + x + beta x^3 + F(x, x') = xi cos(eta t),    barrier at x = r,
// with its 2x2 variational equations, the saltation matrix of the rigid stop, and the loop from one event to the next. Shares
// no code with graze. State: (x, x') if N = 2, (x, x', Phi by columns) if N = 6.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace baselines {

struct Parameters {
  double b = 0.05, beta = 0.0, xi = 1.0, eta = 0.95, r = 2.0;
  double k_H = 100.0, b_H = 0.0;  // Hertz
  double k_r = 1.0;               // Newton
};

enum class Law { hertz, newton };
/// located: an event is searched where the guard changes its sign over a step, and where its speed does (a maximum inside the
/// step). sign_only: only the former, as in a simple program.
enum class Watch { located, sign_only };

template <std::size_t N> using State = std::array<double, N>;

/// The field of free flight or of contact. Beyond its end (x < r, in trial steps) contact continues without force.
template <Law law, std::size_t N> struct Field {
  static constexpr std::size_t size = N;
  using Parameters = baselines::Parameters;
  Parameters p;
  bool in_contact = false;

  /// Acceleration without forcing, and its derivatives in x and v.
  struct Pull {
    double a, a_x, a_v;
  };
  Pull pull(double x, double v) const {
    Pull out{-2.0 * p.b * v - x - p.beta * x * x * x, -1.0 - 3.0 * p.beta * x * x, -2.0 * p.b};
    if constexpr (law == Law::hertz)
      if (in_contact && x > p.r) {
        const double y = std::sqrt(x - p.r), spring = p.k_H * y * y * y, loss = 1.0 + p.b_H * v;
        out.a -= spring * loss;
        out.a_x -= 1.5 * p.k_H * y * loss;
        out.a_v -= spring * p.b_H;
      }
    return out;
  }
  void operator()(double t, const double* u, double* du) const {
    const auto [a, a_x, a_v] = pull(u[0], u[1]);
    du[0] = u[1];
    du[1] = p.xi * std::cos(p.eta * t) + a;
    if constexpr (N == 6) {
      du[2] = u[3];
      du[3] = a_x * u[2] + a_v * u[3];
      du[4] = u[5];
      du[5] = a_x * u[4] + a_v * u[5];
    }
  }
  /// +1: events at the barrier are rising, -1: falling. Events are upward zeros of direction() (x - r).
  double direction() const { return in_contact ? -1.0 : 1.0; }
};

/// A guard and its rate at a time within a step.
struct Guard {
  double value, rate;
};

/// Upward zero of `at` (s -> Guard) between lo (value < 0) and hi (value > 0): Newton's method kept inside the bracket.
/// `falling` finds a zero from above to below.
template <class At> double zero(At&& at, double lo, double hi, double guess, bool falling = false) {
  double s = guess > lo && guess < hi ? guess : 0.5 * (lo + hi);
  for (int i = 0; i < 60 && hi - lo > 4e-16 * (1.0 + hi); ++i) {
    const Guard g = at(s);
    ((g.value < 0.0) != falling ? lo : hi) = s;
    double next = s - g.value / g.rate;
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    if (std::abs(next - s) <= 1e-15 * (1.0 + std::abs(s))) return next;
    s = next;
  }
  return s;
}

/// First upward crossing within a step of length h, or -1. `guard` gives the guard at s, `speed` its rate and acceleration;
/// both describe the motion inside the step. a and b: the guard at its ends; a.value = 0 exactly where the step leaves a guard.
template <class GuardAt, class SpeedAt>
double crossing(Watch watch, const Guard& a, const Guard& b, double h, GuardAt&& guard, SpeedAt&& speed) {
  if (a.value == 0.0 && a.rate < 0.0) {  // it has just left the guard: does it return within the step?
    if (watch == Watch::sign_only && b.value <= 0.0) return -1.0;
    for (int i = 1; i <= 8; ++i) {
      const double s = h * i / 8.0;
      if ((i < 8 ? guard(s).value : b.value) <= 0.0) continue;
      const double below = i > 1 ? h * (i - 1) / 8.0 : zero(speed, 0.0, s, -1.0);
      return zero(guard, below, s, -1.0);
    }
    return -1.0;
  }
  if (a.value > 0.0) return -1.0;
  if (b.value > 0.0) return zero(guard, 0.0, h, h * a.value / (a.value - b.value));
  // A maximum inside. It cannot lie higher than the intersection of the tangents at the ends.
  if (watch == Watch::sign_only || !(a.rate > 0.0 && b.rate < 0.0)) return -1.0;
  if (a.value * b.rate - b.value * a.rate + h * a.rate * b.rate > 0.0) return -1.0;
  const double top = zero(speed, 0.0, h, h * a.rate / (a.rate - b.rate), true);
  return guard(top).value > 0.0 ? zero(guard, 0.0, top, -1.0) : -1.0;
}

struct Stretch {
  double t = 0.0;
  bool event = false, failed = false;
};

struct Run {
  int impacts = 0;
  bool failed = false;
};

/// x' -> -k_r x' at the rigid stop, with the saltation matrix [[-k_r, 0], [(a+ + k_r a-) / x'-, -k_r]].
template <std::size_t N> void strike(const Parameters& p, double t, State<N>& u) {
  const double v = u[1], w = -p.k_r * v;
  const double pull = p.xi * std::cos(p.eta * t) - p.r - p.beta * p.r * p.r * p.r;
  u[0] = p.r;
  u[1] = w;
  if constexpr (N == 6) {
    const double jump = (pull - 2.0 * p.b * w + p.k_r * (pull - 2.0 * p.b * v)) / v;
    for (std::size_t column = 2; column < 6; column += 2) {
      u[column + 1] = jump * u[column] - p.k_r * u[column + 1];
      u[column] *= -p.k_r;
    }
  }
}

/// From t to t_end through all events. `Baseline` has `carry(in_contact, t, t_end, u) -> Stretch`: to t_end or to the first
/// event, where u is then on the barrier.
template <Law law, std::size_t N, class Baseline, class Parameters>
Run run(Baseline& baseline, const Parameters& p, double t, double t_end, State<N>& u) {
  Run out;
  bool in_contact = law == Law::hertz && (u[0] > p.r || (u[0] == p.r && u[1] > 0.0));
  for (int events = 0; events < 1000; ++events) {
    const Stretch stretch = baseline.carry(in_contact, t, t_end, u);
    if (stretch.failed) break;
    if (!stretch.event) return out;
    t = stretch.t;
    u[0] = p.r;
    if (law == Law::newton || !in_contact) ++out.impacts;
    if constexpr (law == Law::newton) strike(p, t, u);
    if constexpr (law == Law::hertz) in_contact = !in_contact;
  }
  out.failed = true;
  return out;
}

template <std::size_t N> State<N> start(double x, double v) {
  State<N> u{};
  u[0] = x;
  u[1] = v;
  if constexpr (N == 6) u[2] = u[5] = 1.0;
  return u;
}

}  // namespace baselines
