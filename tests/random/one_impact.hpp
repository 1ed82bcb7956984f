// SPDX-License-Identifier: GPL-3.0-or-later
// Orbits with one impact in n forcing periods in closed form, at given parameters. With (d, e) the deviation from the impactless
// motion just after the impact (phase phi, approach speed v > 0):
//
//     (d, e) = (1 + k_r) v (Phi(nT) - I)^(-1) (0, 1) = v (alpha, beta)
//     P(phi) = r - alpha v,  P'(phi) = -(k_r + beta) v,  P^2 + (P'/eta)^2 = amplitude^2:   a quadratic for v
//     LP (multiplier +1): both roots are equal, v = r alpha / (alpha^2 + slope^2),  slope = (k_r + beta) / eta
//     PD (multiplier -1): v (1 + det - k_r tr Phi) + (1 + k_r) Phi_12 (xi cos(phi) - r) = 0,  det = k_r^2 e^(-2 b n T),
//         where xi cos(phi) = (1 - eta^2) P + 2 b P' is linear in v, and so is the condition
//     M = S Phi(nT),  tr M = -k_r tr Phi + (1 + k_r) (xi cos(phi) - r) Phi_12 / v,  det M = k_r^2 e^(-2 b n T)
#pragma once

#include "oscillator.hpp"

#include <optional>

namespace graze::reference {

template <class Real> struct OneImpact { Real phase, speed; };

template <class Real> struct OneImpactForm {
  Parameters<Real> q;
  Transition<Real> over;  ///< Phi(nT)
  Real alpha, slope, determinant;
  /// v of the quadratic's a v^2 - 2 h v + c = 0
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
  /// Of the impactless motion, with which an orbit has speed v.
  Real amplitude_of(Real v) const { return root((q[R] - alpha * v) * (q[R] - alpha * v) + slope * v * slope * v); }
  /// Those with v > 0, the slower one first. Admissibility is not checked.
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

/// First value of a parameter, from `from` on to `to`, at which the impactless motion touches the barrier: amplitude = r.
inline std::optional<Quad> touching(const Parameters<double>& base, std::size_t name, double from, double to) {
  constexpr int steps = 4000;
  const auto below = [&](Quad p) {
    Parameters<Quad> q = converted<Quad>(base);
    q[name] = p;
    return q[R] - impactless_amplitude(q);
  };
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
