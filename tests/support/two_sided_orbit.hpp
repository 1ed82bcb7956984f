// SPDX-License-Identifier: GPL-3.0-or-later
// The symmetric orbit of two_sided_oscillator(true) with one impact at each barrier per forcing period, in closed form, and
// the forcing frequency of its pitchfork (symmetry-breaking branch point). In long double, without code of the library.
//
// The upper impact is at phase theta with speed v, leaving with -k_r v; half a period later the lower one has speed -v. With
// the flight z(t) = z_p(t) + Phi (z(t0) - z_p(t0)) and z_p(t + T/2) = -z_p(t) this gives
//     (I + Phi) z_p(theta) = (r, v) + Phi (r, -k_r v),     |z_p| on the ellipse of the forced motion: a quadratic for v.
// Half a period followed by the reflection x -> -x maps the section of the orbit to itself with matrix -Phi S. A multiplier -1
// of this matrix, 1 + trace + det = 0, is the pitchfork.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>

namespace graze::support {

struct TwoSidedOrbit {
  long double theta = 0, v = 0;    ///< eta times the time of the upper impact, in (-pi, pi]; speed before it
  long double trace = 0, det = 0;  ///< of the half-period map -Phi S
  long double x = 0, x_dot = 0;    ///< state at phase 0
  /// Zero at the pitchfork.
  long double pitchfork() const { return 1 + trace + det; }
};

/// `branch`: +1 for the larger speed, -1 for the smaller; nullopt if no orbit with v > 0 exists.
inline std::optional<TwoSidedOrbit> two_sided_orbit(long double b, long double xi, long double eta, long double r,
                                                    long double k_r, int branch = 1) {
  using Long = long double;
  const Long half = std::numbers::pi_v<Long> / eta, q = std::sqrt(1 - b * b);
  const auto flight = [&](Long t, Long& p11, Long& p12, Long& p21, Long& p22) {
    const Long decay = std::exp(-b * t), c = std::cos(q * t), s = std::sin(q * t) / q;
    p11 = decay * (c + b * s), p12 = decay * s, p21 = -decay * s, p22 = decay * (c - b * s);
  };
  Long p11, p12, p21, p22;
  flight(half, p11, p12, p21, p22);
  // (I + Phi)^{-1} of the parts constant and linear in v.
  const Long det = (1 + p11) * (1 + p22) - p12 * p21;
  const auto solve = [&](Long f, Long g, Long& x, Long& y) {
    x = ((1 + p22) * f - p12 * g) / det;
    y = (-p21 * f + (1 + p11) * g) / det;
  };
  Long x0, y0, x1, y1;
  solve(r + p11 * r, p21 * r, x0, y0);
  solve(-k_r * p12, 1 - k_r * p22, x1, y1);
  const Long D = (1 - eta * eta) * (1 - eta * eta) + 4 * b * b * eta * eta, C = xi * (1 - eta * eta) / D,
             S = xi * 2 * b * eta / D;
  const Long alpha = x1 * x1 + y1 * y1 / (eta * eta), beta = x0 * x1 + y0 * y1 / (eta * eta),
             gamma = x0 * x0 + y0 * y0 / (eta * eta) - (C * C + S * S), root = beta * beta - alpha * gamma;
  if (root < 0) return std::nullopt;
  TwoSidedOrbit orbit;
  orbit.v = (-beta + branch * std::sqrt(root)) / alpha;
  if (!(orbit.v > 0)) return std::nullopt;
  // x_p = C cos theta + S sin theta, x_p'/eta = S cos theta - C sin theta.
  const Long x_p = x0 + x1 * orbit.v, y_p = (y0 + y1 * orbit.v) / eta;
  orbit.theta = std::atan2(S * x_p - C * y_p, C * x_p + S * y_p);
  const auto acceleration = [&](Long speed) { return xi * std::cos(orbit.theta) - 2 * b * speed - r; };
  const Long s21 = (acceleration(-k_r * orbit.v) + k_r * acceleration(orbit.v)) / orbit.v;
  orbit.trace = -(p11 * -k_r + p12 * s21 + p22 * -k_r);
  orbit.det = k_r * k_r * std::exp(-2 * b * half);
  // To phase 0, where the period begins: before the upper impact (theta > 0) the flight starts at the lower one, mirrored.
  const bool after_upper = orbit.theta <= 0;
  const Long t = after_upper ? -orbit.theta / eta : half - orbit.theta / eta, sign = after_upper ? 1 : -1;
  const Long from = after_upper ? orbit.theta : orbit.theta - std::numbers::pi_v<Long>;
  const auto forced = [&](Long phase, Long& x, Long& v) {
    x = C * std::cos(phase) + S * std::sin(phase);
    v = eta * (S * std::cos(phase) - C * std::sin(phase));
  };
  Long a, c, d, e, f11, f12, f21, f22;
  forced(from, a, c);
  forced(0, d, e);
  flight(t, f11, f12, f21, f22);
  const Long dx = sign * r - a, dv = -sign * k_r * orbit.v - c;
  orbit.x = d + f11 * dx + f12 * dv;
  orbit.x_dot = e + f21 * dx + f22 * dv;
  return orbit;
}

/// Forcing frequency of the pitchfork between two values that bracket it.
inline long double two_sided_pitchfork(long double b, long double xi, long double r, long double k_r, long double lower,
                                       long double upper) {
  const auto value = [&](long double eta) { return two_sided_orbit(b, xi, eta, r, k_r).value().pitchfork(); };
  const bool rising = value(upper) > 0;
  for (int i = 0; i < 100; ++i) {
    const long double middle = (lower + upper) / 2;
    ((value(middle) > 0) == rising ? upper : lower) = middle;
  }
  return lower;
}

}  // namespace graze::support
