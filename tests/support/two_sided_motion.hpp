// SPDX-License-Identifier: GPL-3.0-or-later
// The motion of two_sided_oscillator(false) in long double, without code of the library: closed-form pieces between elastic
// stops at -r and +r,
//     x'' + 2 b x' + K x = xi cos(eta t) + side k_S r,   K = 1 + k_S beyond a stop (side = +-1), 1 between them (side = 0),
// joined where |x| = r. Steps of a 2000th of the period are compared with the stops, at their ends and at their extremes of x,
// so that no contact is too weak to be found. Bisection follows. Central differences give the multipliers of the period map.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

namespace graze::support {

struct TwoSidedMotion {
  using Long = long double;
  using State = std::array<Long, 2>;

  Long b = 0.05L, xi = 1.0L, eta = 0.9L, r = 1.0L, k_S = 25.0L;

  Long period() const { return 2.0L * std::numbers::pi_v<Long> / eta; }

  /// The piece beyond stop `side` (0: between them) from (t0, z) to t0 + s.
  State piece(int side, Long t0, const State& z, Long s) const {
    const Long K = side == 0 ? 1.0L : 1.0L + k_S, D = (K - eta * eta) * (K - eta * eta) + 4.0L * b * b * eta * eta;
    const Long C = xi * (K - eta * eta) / D, S = xi * 2.0L * b * eta / D, rest = side * k_S * r / K;
    const auto forced = [&](Long t) {
      return State{rest + C * std::cos(eta * t) + S * std::sin(eta * t), eta * (S * std::cos(eta * t) - C * std::sin(eta * t))};
    };
    const State from = forced(t0), to = forced(t0 + s);
    const Long w = std::sqrt(K - b * b), decay = std::exp(-b * s), c = std::cos(w * s), n = std::sin(w * s) / w;
    const Long d = z[0] - from[0], e = z[1] - from[1];
    return {to[0] + decay * ((c + b * n) * d + n * e), to[1] + decay * (-K * n * d + (c - b * n) * e)};
  }

  /// State at phase 0 after `periods` forcing periods.
  State map(State z, int periods = 1) const {
    const int steps = 2000;
    const Long h = period() / steps;
    // Inside its region the gap of the piece is positive. On the border the direction of the speed decides.
    int side = z[0] > r ? 1 : z[0] < -r ? -1 : 0;
    for (int i = 0; i < periods * steps; ++i) {
      Long t = h * i, left = h;
      for (int pieces = 0; pieces < 10; ++pieces) {
        const auto gap = [&](const State& y) { return side == 0 ? r - std::abs(y[0]) : side * y[0] - r; };
        const State end = piece(side, t, z, left);
        Long outside = left;
        bool crosses = gap(end) < 0.0L;
        if (!crosses && end[1] * z[1] < 0.0L) {  // an extreme inside the step, perhaps beyond the border
          Long low = 0.0L, high = left;
          for (int k = 0; k < 70; ++k) {
            const Long middle = (low + high) / 2.0L;
            (piece(side, t, z, middle)[1] * z[1] > 0.0L ? low : high) = middle;
          }
          outside = high;
          crosses = gap(piece(side, t, z, high)) < 0.0L;
        }
        if (!crosses) {
          z = end;
          break;
        }
        Long low = 0.0L, high = outside;
        for (int k = 0; k < 70; ++k) {
          const Long middle = (low + high) / 2.0L;
          (gap(piece(side, t, z, middle)) >= 0.0L ? low : high) = middle;
        }
        z = piece(side, t, z, high);
        t += high;
        left -= high;
        side = side != 0 ? 0 : z[0] > 0.0L ? 1 : -1;
        // On the border, and the step inside, regardless of rounding.
        z[0] = std::copysign(r, z[0]);
      }
    }
    return z;
  }

  struct Tangent {
    Long m11, m12, m21, m22;
    Long trace() const { return m11 + m22; }
    Long det() const { return m11 * m22 - m12 * m21; }
  };
  /// Rounding 1e-18 / 1e-8, and the kinks of the second derivative at weak contacts times 1e-8.
  Tangent tangent(const State& z, int periods = 1) const {
    const Long h = 1e-8L;
    const State a = map({z[0] + h, z[1]}, periods), c = map({z[0] - h, z[1]}, periods);
    const State d = map({z[0], z[1] + h}, periods), e = map({z[0], z[1] - h}, periods);
    return {(a[0] - c[0]) / (2.0L * h), (d[0] - e[0]) / (2.0L * h), (a[1] - c[1]) / (2.0L * h), (d[1] - e[1]) / (2.0L * h)};
  }

  /// Newton's method for the periodic orbit near z; `error` returns the last correction.
  State orbit(State z, int periods, Long& error) const {
    for (int i = 0; i < 8; ++i) {
      const State image = map(z, periods);
      const Tangent M = tangent(z, periods);
      const Long f = image[0] - z[0], g = image[1] - z[1], p = M.m11 - 1.0L, q = M.m22 - 1.0L, det = p * q - M.m12 * M.m21;
      const Long dx = -(q * f - M.m12 * g) / det, dy = -(p * g - M.m21 * f) / det;
      z = {z[0] + dx, z[1] + dy};
      error = std::hypot(dx, dy);
    }
    return z;
  }
};

}  // namespace graze::support
