// SPDX-License-Identifier: GPL-3.0-or-later
// Closed form of the periodic orbits of the linear oscillator with Newton's law (beta = 0) that hit the barrier once in n
// forcing periods. It gives the orbits at given parameters, and their family in the forcing amplitude with its fold and its
// grazing. This reference shares no code with the library: no integration, no event location, no Newton's method.
//
//     x'' + 2 b x' + x = xi cos(eta t),  x <= r,  x'+ = -k_r x'-       dimensionless
//
// P(t) = A cos(eta t) + B sin(eta t) is the impactless motion. (d, e) = (r - P, u - P') is the deviation from it just after
// the impact at time t0; v > 0 is the approach speed, u = -k_r v the speed after. After n periods P is the same, and the
// flight gives
//     Phi(nT) (d, e) = (d, e + v - u)   ->   (d, e) = (1 + k_r) v (Phi - I)^{-1} (0, 1) = v (alpha, beta):  linear in v.
// Then P(t0) = r - alpha v, P'(t0) = -(k_r + beta) v, and P^2 + (P'/eta)^2 = A^2 + B^2 is a quadratic for v. The phase of
// impact follows from P and P'. There are up to two orbits. They are born in a fold (discriminant 0) and graze at v = 0, where
// the amplitude equals |r|. Conversely, the amplitude is a function of v, and its square a parabola with the fold in xi at its
// vertex.
//     M = S Phi(nT),   S = [[-k_r, 0], [(a+ + k_r a-)/v, -k_r]],   a+- = xi cos(eta t0) - 2 b x'+- - r:
//     trace M = -k_r trace Phi + (a+ + k_r a-)/v Phi_12,   det M = k_r^2 exp(-2 b n T)     give the multipliers.
// Valid for every r (including 0 and below), every k_r in [0, 1], 0 <= b < 1. With k_r = 0 the mass must be pulled off the
// barrier (`leaves`); otherwise it would stick.
#pragma once

#include <graze/lib/numerics/vector.hpp>

#include <Eigen/LU>

#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

namespace graze::support {

struct OneImpactParameters {
  double b = 0.05, xi = 1.0, eta = 1.0, r = 1.0, k_r = 0.8;
  double period() const { return 2.0 * std::numbers::pi / eta; }
};

struct OneImpactOrbit {
  OneImpactParameters parameters;
  int n = 1;
  double speed = 0.0;                               ///< v, of approach
  double time = 0.0;                                ///< t0 of the impact, in [0, T)
  std::array<std::complex<double>, 2> multipliers;  ///< by decreasing modulus
  double highest = 0.0;                             ///< largest interior maximum of the flight, minus r; -infinity: none
  bool leaves = false;                              ///< it leaves the barrier after the impact
  bool admissible() const { return leaves && highest < 0.0; }
  bool stable() const { return std::abs(multipliers[0]) < 1.0; }

  /// State at time t0 + s of the flight, 0 < s <= nT.
  Vector flight(double s) const;
  /// States at forcing phase 0 after the impact: at T, 2T, ... nT.
  std::vector<Vector> states() const;
};

namespace detail {

inline Eigen::Matrix2d flight_transition(double b, double s) {
  const double w = std::sqrt(1.0 - b * b), c = std::cos(w * s), sn = std::sin(w * s) / w, decay = std::exp(-b * s);
  Eigen::Matrix2d Phi;
  Phi << c + b * sn, sn, -sn, c - b * sn;
  return decay * Phi;
}

/// (P, P') of the impactless motion.
inline Eigen::Vector2d impactless(const OneImpactParameters& q, double t) {
  const double stiff = 1.0 - q.eta * q.eta, drag = 2.0 * q.b * q.eta, D = stiff * stiff + drag * drag;
  const double A = q.xi * stiff / D, B = q.xi * drag / D, c = std::cos(q.eta * t), s = std::sin(q.eta * t);
  return {A * c + B * s, q.eta * (B * c - A * s)};
}

}  // namespace detail

/// Amplitude of the impactless motion, xi / sqrt((1 - eta^2)^2 + (2 b eta)^2).
inline double impactless_amplitude(const OneImpactParameters& q) {
  return std::abs(q.xi) / std::hypot(1.0 - q.eta * q.eta, 2.0 * q.b * q.eta);
}

inline Vector OneImpactOrbit::flight(double s) const {
  const OneImpactParameters& q = parameters;
  const Eigen::Vector2d start = Eigen::Vector2d(q.r, -q.k_r * speed) - detail::impactless(q, time);
  return detail::impactless(q, time + s) + detail::flight_transition(q.b, s) * start;
}

inline std::vector<Vector> OneImpactOrbit::states() const {
  std::vector<Vector> list;
  for (int k = 1; k <= n; ++k) list.push_back(flight(k * parameters.period() - time));
  return list;
}

/// All orbits with one impact in n forcing periods that differ only in v and xi.
struct OneImpactFamily {
  double r = 0.0, alpha = 0.0, slope = 0.0;  ///< P(t0) = r - alpha v, P'(t0) / eta = -slope v
  double gain = 0.0;                         ///< amplitude of the impactless motion per unit of xi
  double turn = 0.0;                         ///< sqrt(1 - b^2) n T
  double amplitude(double v) const { return std::hypot(r - alpha * v, slope * v); }
  double xi(double v) const { return amplitude(v) / gain; }
  /// Speed at the smallest xi; there is a fold in xi if it is positive.
  double fold_speed() const { return r * alpha / (alpha * alpha + slope * slope); }
  double xi_fold() const { return xi(fold_speed()); }
  double xi_grazing() const { return xi(0.0); }
};

inline OneImpactFamily one_impact_family(const OneImpactParameters& q, int n) {
  const double nT = n * q.period();
  const Eigen::Matrix2d Phi = detail::flight_transition(q.b, nT);
  const Eigen::Vector2d w = (Phi - Eigen::Matrix2d::Identity()).inverse() * Eigen::Vector2d(0.0, 1.0 + q.k_r);
  const double gain = 1.0 / std::hypot(1.0 - q.eta * q.eta, 2.0 * q.b * q.eta);
  return {q.r, w[0], (q.k_r + w[1]) / q.eta, gain, std::sqrt(1.0 - q.b * q.b) * nT};
}

/// The orbit with impact speed v, at parameters for which it exists (see OneImpactFamily).
inline OneImpactOrbit one_impact_orbit(const OneImpactParameters& q, int n, double v) {
  const double T = q.period();
  const Eigen::Matrix2d Phi = detail::flight_transition(q.b, n * T);
  const OneImpactFamily family = one_impact_family(q, n);
  const double alpha = family.alpha, slope = family.slope;
  OneImpactOrbit orbit;
  orbit.parameters = q;
  orbit.n = n;
  orbit.speed = v;
  // P = A cos + B sin and P'/eta = B cos - A sin: the phase is that of (A, B) minus that of (P, -P'/eta).
  const Eigen::Vector2d at_zero = detail::impactless(q, 0.0);
  const double phase = std::atan2(at_zero[1] / q.eta, at_zero[0]) - std::atan2(-slope * v, q.r - alpha * v);
  orbit.time = std::fmod(phase / q.eta, T);
  if (orbit.time < 0.0) orbit.time += T;
  const double force = q.xi * std::cos(q.eta * orbit.time) - q.r;
  const double before = force - 2.0 * q.b * v, after = force + 2.0 * q.b * q.k_r * v;
  const double half_trace = 0.5 * (-q.k_r * Phi.trace() + (after + q.k_r * before) / v * Phi(0, 1));
  const double det = q.k_r * q.k_r * std::exp(-2.0 * q.b * n * T), inner = half_trace * half_trace - det;
  if (inner < 0.0) {
    orbit.multipliers = {std::complex<double>(half_trace, std::sqrt(-inner)), {half_trace, -std::sqrt(-inner)}};
  } else {
    const double large = half_trace + std::copysign(std::sqrt(inner), half_trace);
    orbit.multipliers = {large, large == 0.0 ? 0.0 : det / large};
  }
  orbit.leaves = q.k_r * v > 0.0 || after < 0.0;
  // A flight that passes the barrier has a maximum beyond it: samples at a 2000th of a period, then Newton's method on the
  // speed.
  const int samples = 2000 * n;
  orbit.highest = -std::numeric_limits<double>::infinity();
  for (int i = 1; i < samples; ++i) {
    double s = n * T * i / samples;
    const double h = n * T / samples;
    const Vector here = orbit.flight(s), next = orbit.flight(s + h);
    if (!(here[1] > 0.0 && next[1] <= 0.0)) continue;
    for (int k = 0; k < 8; ++k) {
      const Vector x = orbit.flight(s);
      s -= x[1] / (q.xi * std::cos(q.eta * (orbit.time + s)) - 2.0 * q.b * x[1] - x[0]);
    }
    orbit.highest = std::max(orbit.highest, orbit.flight(s)[0] - q.r);
  }
  return orbit;
}

/// The orbits with one impact in n forcing periods: none, one or two, the faster one first. They include inadmissible ones.
inline std::vector<OneImpactOrbit> one_impact_orbits(const OneImpactParameters& q, int n) {
  const double amplitude = impactless_amplitude(q);
  const OneImpactFamily family = one_impact_family(q, n);
  const double alpha = family.alpha, slope = family.slope;
  // (alpha^2 + slope^2) v^2 - 2 r alpha v + r^2 - amplitude^2 = 0.
  const double a = alpha * alpha + slope * slope, half = q.r * alpha, c = (q.r - amplitude) * (q.r + amplitude);
  const double discriminant = half * half - a * c;
  std::vector<OneImpactOrbit> list;
  if (discriminant < 0.0) return list;
  const double larger = half + std::copysign(std::sqrt(discriminant), half);
  std::array<double, 2> speeds{larger / a, c / larger};
  if (speeds[0] < speeds[1]) std::swap(speeds[0], speeds[1]);
  for (const double v : speeds) {
    if (!(v > 0.0)) continue;
    list.push_back(one_impact_orbit(q, n, v));
  }
  return list;
}

}  // namespace graze::support
