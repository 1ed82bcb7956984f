// SPDX-License-Identifier: GPL-3.0-or-later
// The oscillator of the reference, dimensionless, in closed form between impacts:
//
//     x'' + 2 b x' + x = xi cos(phi),  phi = eta tau,  x <= r,  x'+ = -k_r x'-  at x = r
//     P(phi) = A cos(phi) + B sin(phi),  (A, B) = xi (1 - eta^2, 2 b eta) / ((1 - eta^2)^2 + (2 b eta)^2)     impactless motion
//     (x, x')(tau + s) = (P, P')(phi + eta s) + Phi(s) ((x, x')(tau) - (P, P')(phi))
//     Phi(s) = e^(-b s) [cos(w s) + (b/w) sin(w s), sin(w s)/w; -sin(w s)/w, cos(w s) - (b/w) sin(w s)],  w = sqrt(1 - b^2)
#pragma once

#include "real.hpp"

#include <array>

namespace graze::reference {

enum Name : std::size_t { B, XI, ETA, R, K_R, L, K_L, MASS = 5, K, C };

/// By Name. Parameters that a model does not have are 0.
template <class Real> using Parameters = std::array<Real, 8>;

template <class To, class From> Parameters<To> converted(const Parameters<From>& from) {
  Parameters<To> out;
  for (std::size_t i = 0; i < from.size(); ++i) out[i] = static_cast<To>(from[i]);
  return out;
}

template <class Real> struct Motion { Real x, v; };

template <class Real> struct Transition {
  Real xx, xv, vx, vv;
  Motion<Real> operator*(const Motion<Real>& d) const { return {xx * d.x + xv * d.v, vx * d.x + vv * d.v}; }
};

template <class Real> Transition<Real> transition(const Parameters<Real>& q, Real s) {
  const Real w = root(Real(1) - q[B] * q[B]), decay = exponential(-q[B] * s);
  const Real c = decay * cosine(w * s), sn = decay * sine(w * s) / w;
  return {c + q[B] * sn, sn, -sn, c - q[B] * sn};
}

template <class Real> Motion<Real> impactless(const Parameters<Real>& q, Real phase) {
  const Real stiff = Real(1) - q[ETA] * q[ETA], drag = Real(2) * q[B] * q[ETA];
  const Real factor = q[XI] / (stiff * stiff + drag * drag), c = cosine(phase), s = sine(phase);
  return {factor * (stiff * c + drag * s), factor * q[ETA] * (drag * c - stiff * s)};
}

template <class Real> Real impactless_amplitude(const Parameters<Real>& q) {
  const Real stiff = Real(1) - q[ETA] * q[ETA], drag = Real(2) * q[B] * q[ETA];
  return magnitude(q[XI]) / root(stiff * stiff + drag * drag);
}

template <class Real> Real acceleration(const Parameters<Real>& q, Real phase, const Motion<Real>& at) {
  return q[XI] * cosine(phase) - Real(2) * q[B] * at.v - at.x;
}

/// The flight from `at` (at `phase`), a time s later.
template <class Real> Motion<Real> flight(const Parameters<Real>& q, Real phase, const Motion<Real>& at, Real s) {
  const Motion<Real> here = impactless(q, phase), there = impactless(q, phase + q[ETA] * s);
  const Motion<Real> deviation = transition(q, s) * Motion<Real>{at.x - here.x, at.v - here.v};
  return {there.x + deviation.x, there.v + deviation.v};
}

}  // namespace graze::reference
