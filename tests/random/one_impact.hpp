// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits with one impact in n forcing periods in closed form, at given parameters. (d, e) is the deviation from the impactless
// motion just after the impact (phase phi, approach speed v > 0):
//
//     (d, e) = (1 + k_r) v (Phi(nT) - I)^(-1) (0, 1) = v (alpha, beta)
//     P(phi) = r - alpha v,  P'(phi) = -(k_r + beta) v,  P^2 + (P'/eta)^2 = amplitude^2:   a quadratic for v
//     LP (multiplier +1): both roots are equal, v = r alpha / (alpha^2 + slope^2),  slope = (k_r + beta) / eta
//     PD (multiplier -1): v (1 + det - k_r tr Phi) + (1 + k_r) Phi_12 (xi cos(phi) - r) = 0,  det = k_r^2 e^(-2 b n T),
//         where xi cos(phi) = (1 - eta^2) P + 2 b P' is linear in v, and so is the condition
//     M = S Phi(nT),  tr M = -k_r tr Phi + (1 + k_r) (xi cos(phi) - r) Phi_12 / v,  det M = k_r^2 e^(-2 b n T)
#pragma once

#include "impact_equations.hpp"

#include <optional>

namespace graze::reference {

template <class Real> struct OneImpact { Real phase, speed; };

template <class Real> struct OneImpactForm {
  Parameters<Real> q;
  Transition<Real> over;  ///< Phi(nT)
  Real alpha, slope, determinant;
  /// v from the quadratic a v^2 - 2 h v + c = 0
  Real a() const { return alpha * alpha + slope * slope; }
  Real h() const { return q[R] * alpha; }
  Real c() const { return q[R] * q[R] - impactless_amplitude(q) * impactless_amplitude(q); }
  Real discriminant() const { return h() * h() - a() * c(); }
  Real fold_speed() const { return h() / a(); }
  /// xi cos(phi) - r at the impact with speed v.
  Real force(Real v) const {
    return (Real(1) - q[ETA] * q[ETA]) * (q[R] - alpha * v) - Real(2) * q[B] * slope * q[ETA] * v - q[R];
  }
  Real flip_speed() const {
    const Real factor = (Real(1) + q[K_R]) * over.xv, at_zero = force(Real(0)), per_speed = force(Real(1)) - at_zero;
    return -factor * at_zero / (Real(1) + determinant - q[K_R] * (over.xx + over.vv) + factor * per_speed);
  }
  Real trace(Real v) const { return -q[K_R] * (over.xx + over.vv) + (Real(1) + q[K_R]) * force(v) * over.xv / v; }
  /// Left side of the quadratic for the speed.
  Real mismatch(Real v) const { return (a() * v - Real(2) * h()) * v + c(); }
  OneImpact<Real> orbit(Real v) const {
    const Motion<Real> zero = impactless(q, Real(0));
    Real phase = arctangent(zero.v / q[ETA], zero.x) - arctangent(-slope * v, q[R] - alpha * v);
    while (phase < Real(0)) phase += Real(2) * pi<Real>();
    while (phase >= Real(2) * pi<Real>()) phase -= Real(2) * pi<Real>();
    return {phase, v};
  }
  /// Amplitude of the impactless motion at which an orbit has speed v.
  Real amplitude_of(Real v) const { return root((q[R] - alpha * v) * (q[R] - alpha * v) + slope * v * slope * v); }
  /// Roots with v > 0, the slower one first. Admissibility is not checked.
  Values<Real> speeds() const {
    Values<Real> out;
    if (discriminant() < Real(0)) return out;
    for (const Real sign : {Real(-1), Real(1)}) {
      const Real v = (h() + sign * root(discriminant())) / a();
      if (v > Real(0)) out.push_back(v);
    }
    return out;
  }
};

template <class Real> OneImpactForm<Real> one_impact(const Parameters<Real>& q, int n) {
  const Real nT = Real(2 * n) * pi<Real>() / q[ETA];
  const Transition<Real> over = transition(q, nT);
  const Real determinant = (over.xx - Real(1)) * (over.vv - Real(1)) - over.xv * over.vx;
  const Real alpha = -(Real(1) + q[K_R]) * over.xv / determinant;
  const Real beta = (Real(1) + q[K_R]) * (over.xx - Real(1)) / determinant;
  return {q, over, alpha, (q[K_R] + beta) / q[ETA], q[K_R] * q[K_R] * exponential(-Real(2) * q[B] * nT)};
}

/// The same for any model, with one impact in the turn of `frame`: for a symmetric orbit, in one half of it. d is the
/// deviation from the impactless motion P just after the impact, and sigma = -1 for one half, otherwise 1:
///
///     d - sigma exp(A turn) d = -(1 + e) w (0, kick),  row . P_q = wall - alpha w,  row . P_v = eta slope w
///     (row . P_q)^2 + (row . P_v / eta)^2 = amplitude^2:   a quadratic for w
template <class Real> struct SingleImpact {
  Linear<Real> system;
  Stop<Real> stop;
  Point<Real> before;  ///< sigma exp(A turn) d / w
  Real alpha, slope;
  Real mismatch(Real w) const {
    const Real amplitude = impactless_amplitude(system, stop), x = stop.wall - alpha * w;
    return x * x + slope * w * slope * w - amplitude * amplitude;
  }
  /// Roots with w > 0, the slower one first.
  Values<Real> speeds() const {
    const Real a = alpha * alpha + slope * slope, h = stop.wall * alpha, c = mismatch(Real(0)), inner = h * h - a * c;
    Values<Real> out;
    if (inner < Real(0)) return out;
    for (const Real sign : {Real(-1), Real(1)})
      if (h + sign * root(inner) > Real(0)) out.push_back((h + sign * root(inner)) / a);
    return out;
  }
  Values<Real> block(Real w) const {
    const Real g = stop.height(system.in_cos) + stop.wall, k = stop.height(system.in_sin) + stop.wall;
    Real phase = arctangent(k, g) - arctangent(slope * w, stop.wall - alpha * w);
    while (phase < Real(0)) phase += Real(2) * pi<Real>();
    return block_of(system, stop, phase, plus(impactless(system, phase), w, before));
  }
};

template <class Real> SingleImpact<Real> single_impact(const Frame& frame, Real value) {
  SingleImpact<Real> out;
  out.system = frame.system(value);
  out.stop = out.system.stops[static_cast<std::size_t>(frame.stops.front())];
  const std::size_t n = frame.block();
  const Square<Real> over = transition(out.system, frame.turn<Real>() / out.system.q[ETA]);
  Table<Real> closing(n, n);
  Values<Real> d(n, Real(0));
  const Real sigma(frame.half ? -1 : 1), change = Real(1) + out.stop.restitution;
  Point<Real> jump{Real(0), Real(0), -change * out.stop.kick[0], -change * out.stop.kick[1]}, after{};
  for (std::size_t i = 0; i < n; ++i) {
    d[i] = jump[out.system.index(i)];
    for (std::size_t j = 0; j < n; ++j)
      closing(i, j) = Real(i == j ? 1 : 0) - sigma * over[out.system.index(i)][out.system.index(j)];
  }
  solve(closing, d);
  for (std::size_t i = 0; i < n; ++i) after[out.system.index(i)] = d[i];
  out.before = plus(after, Real(-1), jump);
  out.alpha = out.stop.height(out.before) + out.stop.wall;
  out.slope = (Real(1) - out.stop.speed(out.before)) / out.system.q[ETA];
  return out;
}

/// First value of a parameter, between `from` and `to`, at which the impactless motion touches a stop.
inline std::optional<Quad> touching(const Frame& frame, double from, double to) {
  constexpr int steps = 4000;
  const auto below = [&](Quad p) { return clearance(frame.system(p)); };
  Quad low = from;
  for (int k = 1; k <= steps; ++k) {
    Quad high = Quad(from) + (Quad(to) - Quad(from)) * Quad(k) / Quad(steps);
    if (below(high) > Quad(0)) {
      low = high;
      continue;
    }
    for (int i = 0; i < 110; ++i) {
      const Quad middle = (low + high) / Quad(2);
      (below(middle) > Quad(0) ? low : high) = middle;
    }
    return low;
  }
  return std::nullopt;
}

}  // namespace graze::reference
