// SPDX-License-Identifier: GPL-3.0-or-later
// The models of the reference: linear systems of one or two masses with restitution at one or two stops, in closed form between
// impacts.
//
//     M q'' + C q' + K q = F cos(phi),  phi = eta t,  row . q <= wall
//     v+ = v- - (1 + e) kick (row . v-),  kick = M^-1 row / (row . M^-1 row)                at row . q = wall
//     P(phi) = in_cos cos(phi) + in_sin sin(phi)                                            impactless motion
//     z(t + s) = P(phi + eta s) + exp(A s) (z(t) - P(phi)),  z = (q, q'),  z' = A z + force cos(phi)
//
// The exponential of one mass is in oscillator.hpp; that of two masses is a Taylor series with scaling and squaring.
#pragma once

#include "oscillator.hpp"

#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace graze::reference {

/// The problem files are systems/NAME.toml, except for the first: newton-elastic.toml.
enum class Model { barrier, equal_stops, two_stops, chain_first, chain_second, chain_between };
inline constexpr std::array<std::string_view, 6> model_names = {"newton-elastic", "two-equal-stops", "two-stops",
                                                                "chain-first",    "chain-second",    "chain-between"};

inline bool is_chain(Model model) { return model >= Model::chain_first; }

/// By Name.
inline std::span<const std::string_view> parameter_names(Model model) {
  static constexpr std::array<std::string_view, 7> one = {"b", "xi", "eta", "r", "k_r", "l", "k_l"};
  static constexpr std::array<std::string_view, 8> two = {"b", "xi", "eta", "r", "k_r", "m", "k", "c"};
  if (is_chain(model)) return two;
  return std::span(one).first(model == Model::two_stops ? 7 : 5);
}

/// (q_1, q_2, v_1, v_2). With one mass q_2 and v_2 are 0.
template <class Real> using Point = std::array<Real, 4>;
template <class Real> using Square = std::array<Point<Real>, 4>;

template <class Real> Point<Real> operator*(const Square<Real>& M, const Point<Real>& z) {
  Point<Real> out;
  for (std::size_t i = 0; i < 4; ++i) out[i] = M[i][0] * z[0] + M[i][1] * z[1] + M[i][2] * z[2] + M[i][3] * z[3];
  return out;
}

template <class Real> Square<Real> operator*(const Square<Real>& M, const Square<Real>& N) {
  Square<Real> out{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t k = 0; k < 4; ++k)
      for (std::size_t j = 0; j < 4; ++j) out[i][j] += M[i][k] * N[k][j];
  return out;
}

/// a + factor b
template <class Real> Point<Real> plus(Point<Real> a, Real factor, const Point<Real>& b) {
  for (std::size_t i = 0; i < 4; ++i) a[i] += factor * b[i];
  return a;
}

template <class Real> struct Stop {
  std::array<Real, 2> row{}, kick{};
  Real wall{}, restitution{};
  Real height(const Point<Real>& z) const { return row[0] * z[0] + row[1] * z[1] - wall; }
  Real speed(const Point<Real>& z) const { return row[0] * z[2] + row[1] * z[3]; }
  Point<Real> rebound(Point<Real> z) const {
    const Real change = (Real(1) + restitution) * speed(z);
    z[2] -= change * kick[0];
    z[3] -= change * kick[1];
    return z;
  }
  /// The coordinate fixed by the wall, and the free one.
  std::size_t bound() const { return row[0] != Real(0) ? 0 : 1; }
  std::size_t free() const { return 1 - bound(); }
};

template <class Real> struct Linear {
  bool chain = false;
  Parameters<Real> q{};
  Square<Real> A{};
  Point<Real> force{}, in_cos{}, in_sin{};
  std::vector<Stop<Real>> stops;
  /// Number of unknowns of an impact, and of states.
  std::size_t size() const { return chain ? 4 : 2; }
  /// Index in a Point of state k of the program, and of equation k.
  std::size_t index(std::size_t k) const { return chain ? k : 2 * k; }
};

template <class Real> Linear<Real> linear(Model model, const Parameters<Real>& q) {
  Linear<Real> out;
  out.chain = is_chain(model);
  out.q = q;
  const Real m = out.chain ? q[MASS] : Real(1), k = out.chain ? q[K] : Real(0), c = out.chain ? q[C] : Real(0);
  out.A[0] = {Real(0), Real(0), Real(1), Real(0)};
  out.A[2] = {-(Real(1) + k), k, -(Real(2) * q[B] + c), c};
  if (out.chain) {
    out.A[1] = {Real(0), Real(0), Real(0), Real(1)};
    out.A[3] = {k / m, -k / m, c / m, -c / m};
  }
  out.force[2] = q[XI];
  const auto stop = [&](Real first, Real second, Real wall, Real restitution) {
    const Real whole = first * first + second * second / m;
    out.stops.push_back({{first, second}, {first / whole, second / (m * whole)}, wall, restitution});
  };
  switch (model) {
  case Model::chain_second:
    stop(Real(0), Real(1), q[R], q[K_R]);
    break;
  case Model::chain_between:
    stop(Real(1), Real(-1), q[R], q[K_R]);
    break;
  default:
    stop(Real(1), Real(0), q[R], q[K_R]);
  }
  if (model == Model::equal_stops) stop(Real(-1), Real(0), q[R], q[K_R]);
  if (model == Model::two_stops) stop(Real(-1), Real(0), q[L], q[K_L]);
  // eta in_sin = A in_cos + force,  -eta in_cos = A in_sin
  const std::size_t n = out.size();
  Table<Real> T(2 * n, 2 * n);
  Values<Real> y(2 * n, Real(0));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) T(i, j) = T(i + n, j + n) = out.A[out.index(i)][out.index(j)];
    T(i, i + n) = -q[ETA];
    T(i + n, i) = q[ETA];
    y[i] = -out.force[out.index(i)];
  }
  solve(T, y);
  for (std::size_t i = 0; i < n; ++i) {
    out.in_cos[out.index(i)] = y[i];
    out.in_sin[out.index(i)] = y[i + n];
  }
  return out;
}

/// Terms of the series of exp(X), |X| < 1/2, with a remainder below rounding.
inline int exponential_terms(double) { return 16; }
inline int exponential_terms(Quad) { return 28; }

template <class Real> Square<Real> transition(const Linear<Real>& system, Real s) {
  Square<Real> out{};
  if (!system.chain) {
    const Transition<Real> over = transition(system.q, s);
    out[0] = {over.xx, Real(0), over.xv, Real(0)};
    out[2] = {over.vx, Real(0), over.vv, Real(0)};
    return out;
  }
  Real size(0);
  for (const Point<Real>& row : system.A) {
    Real sum(0);
    for (const Real& entry : row) sum += magnitude(entry);
    size = std::max(size, sum * magnitude(s));
  }
  int squarings = 0;
  for (; size > Real(0.5); size /= Real(2)) {
    s /= Real(2);
    ++squarings;
  }
  // Horner's scheme: I + X (I + X/2 (I + X/3 ...))
  for (std::size_t i = 0; i < 4; ++i) out[i][i] = Real(1);
  for (int k = exponential_terms(s); k > 0; --k) {
    out = system.A * out;
    for (std::size_t i = 0; i < 4; ++i) {
      for (Real& entry : out[i]) entry *= s / Real(k);
      out[i][i] += Real(1);
    }
  }
  for (int k = 0; k < squarings; ++k) out = out * out;
  return out;
}

template <class Real> Point<Real> impactless(const Linear<Real>& system, Real phase) {
  return plus(plus(Point<Real>{}, cosine(phase), system.in_cos), sine(phase), system.in_sin);
}

/// Largest row . q of the impactless motion.
template <class Real> Real impactless_amplitude(const Linear<Real>& system, const Stop<Real>& stop) {
  const Real a = stop.row[0] * system.in_cos[0] + stop.row[1] * system.in_cos[1];
  const Real b = stop.row[0] * system.in_sin[0] + stop.row[1] * system.in_sin[1];
  return root(a * a + b * b);
}

/// Distance of the impactless motion from the nearest stop: positive if it touches none.
template <class Real> Real clearance(const Linear<Real>& system) {
  Real least(1e30);
  for (const Stop<Real>& stop : system.stops) least = std::min(least, stop.wall - impactless_amplitude(system, stop));
  return least;
}

/// z'
template <class Real> Point<Real> rate(const Linear<Real>& system, Real phase, const Point<Real>& z) {
  return plus(system.A * z, cosine(phase), system.force);
}

/// The flight from z (at `phase`), a time s later.
template <class Real> Point<Real> flight(const Linear<Real>& system, Real phase, const Point<Real>& z, Real s) {
  return plus(impactless(system, phase + system.q[ETA] * s), Real(1),
              transition(system, s) * plus(z, Real(-1), impactless(system, phase)));
}

/// Upper bound of its angular frequencies, including that of the forcing.
inline double fastest(const Linear<double>& system) {
  double most = std::max(1.0, system.q[ETA]);
  for (const std::size_t i : {2, 3}) most = std::max(most, std::sqrt(std::fabs(system.A[i][0]) + std::fabs(system.A[i][1])));
  return most;
}

}  // namespace graze::reference
