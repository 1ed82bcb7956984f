// SPDX-License-Identifier: GPL-3.0-or-later
// The equations of orbits with m impacts in n forcing periods, and of their families in a parameter p, in the coordinates of the
// events. The unknowns y = (phi_1, v_1, ..., phi_m, v_m, p) are the impacts' phases and approach speeds:
//
//     flight from (r, -k_r v_i) at phi_i to phi_{i+1}:   x - r = 0,  x' - v_{i+1} = 0,     phi_{m+1} = phi_1 + 2 pi n
//
// They are smooth through v_i = 0. Let A_i, B_i be the derivatives by (phi, v)_i and (phi, v)_{i+1}, and J(kappa) their cyclic
// matrix with kappa B_m in its corner. A multiplier +1 (fold) is det J(1) = 0, a multiplier -1 (doubling) det J(-1) = 0: the
// impacts' speeds, by which the multipliers' own conditions are singular, are divided out. B is singular at v = 0, J is not.
#pragma once

#include "oscillator.hpp"

#include <algorithm>
#include <optional>

namespace graze::reference {

/// The constants of a family: every parameter but one, the periods and the impacts.
struct Frame {
  Parameters<double> base{};
  std::size_t name = ETA;  ///< of the parameter that changes
  int periods = 1, impacts = 1;
  std::size_t size() const { return 2 * static_cast<std::size_t>(impacts); }
  template <class Real> Parameters<Real> at(Real value) const {
    Parameters<Real> q = converted<Real>(base);
    q[name] = value;
    return q;
  }
};

/// The flight from one impact to the next, and the end's derivatives.
template <class Real> struct Leg {
  Real phase, duration;
  Motion<Real> start, end;
  Motion<Real> by_phase, by_speed;  ///< of the end, by the start's phase and approach speed
  Motion<Real> by_end_phase;        ///< of the end, by its own phase
};

template <class Real> Leg<Real> leg(const Frame& frame, const Values<Real>& y, int i) {
  const std::size_t k = 2 * static_cast<std::size_t>(i), next = i + 1 == frame.impacts ? 0 : k + 2;
  const Parameters<Real> q = frame.at(y[frame.size()]);
  Leg<Real> out;
  out.phase = y[k];
  const Real there = y[next] + (next == 0 ? Real(2 * frame.periods) * pi<Real>() : Real(0));
  out.duration = (there - y[k]) / q[ETA];
  out.start = {q[R], -q[K_R] * y[k + 1]};
  out.end = flight(q, out.phase, out.start, out.duration);
  const Transition<Real> over = transition(q, out.duration);
  const Real a = acceleration(q, out.phase, out.start);
  out.by_phase = over * Motion<Real>{-out.start.v / q[ETA], -a / q[ETA]};
  out.by_speed = over * Motion<Real>{Real(0), -q[K_R]};
  out.by_end_phase = {out.end.v / q[ETA], acceleration(q, there, out.end) / q[ETA]};
  return out;
}

template <class Real> Values<Real> residual(const Frame& frame, const Values<Real>& y) {
  Values<Real> out;
  for (int i = 0; i < frame.impacts; ++i) {
    const Leg<Real> here = leg(frame, y, i);
    const std::size_t next = i + 1 == frame.impacts ? 0 : 2 * static_cast<std::size_t>(i) + 2;
    out.push_back(here.end.x - frame.at(y[frame.size()])[R]);
    out.push_back(here.end.v - y[next + 1]);
  }
  return out;
}

/// J(kappa), square.
template <class Real> Table<Real> jacobian(const Frame& frame, const Values<Real>& y, Real kappa) {
  Table<Real> J(frame.size(), frame.size());
  for (int i = 0; i < frame.impacts; ++i) {
    const Leg<Real> here = leg(frame, y, i);
    const std::size_t k = 2 * static_cast<std::size_t>(i), next = i + 1 == frame.impacts ? 0 : k + 2;
    const Real factor = next == 0 ? kappa : Real(1);
    J(k, k) += here.by_phase.x;
    J(k + 1, k) += here.by_phase.v;
    J(k, k + 1) += here.by_speed.x;
    J(k + 1, k + 1) += here.by_speed.v;
    J(k, next) += factor * here.by_end_phase.x;
    J(k + 1, next) += factor * here.by_end_phase.v;
    J(k + 1, next + 1) -= factor;
  }
  return J;
}

/// Step of the central difference by p: the error, of second order, is at the root of rounding.
inline double difference_step(double) { return 1e-6; }
inline Quad difference_step(Quad) { return Quad(1e-11); }

template <class Real> Values<Real> by_parameter(const Frame& frame, const Values<Real>& y) {
  const Real h = difference_step(Real(0)) * (Real(0.1) + magnitude(y.back()));
  Values<Real> up = y, down = y;
  up.back() += h;
  down.back() -= h;
  Values<Real> out = residual(frame, up), low = residual(frame, down);
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = (out[i] - low[i]) / (Real(2) * h);
  return out;
}

template <class Real> Real condition(const Frame& frame, const Values<Real>& y, int kappa) {
  Values<Real> unused(frame.size(), Real(0));
  return solve(jacobian(frame, y, Real(kappa)), unused);
}

/// One linear equation for y besides the orbit's: row . y = value.
template <class Real> struct Constraint {
  Values<Real> row;
  Real value;
};

/// p = value
template <class Real> Constraint<Real> fixed_parameter(const Frame& frame, Real value) {
  Constraint<Real> out{Values<Real>(frame.size() + 1, Real(0)), value};
  out.row[frame.size()] = Real(1);
  return out;
}

/// The Jacobian by y, p included, with the constraint's row below.
template <class Real> Table<Real> bordered(const Frame& frame, const Values<Real>& y, const Values<Real>& row) {
  const std::size_t n = frame.size();
  const Table<Real> J = jacobian(frame, y, Real(1));
  const Values<Real> slope = by_parameter(frame, y);
  Table<Real> out(n + 1, n + 1);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) out(i, j) = J(i, j);
    out(i, n) = slope[i];
  }
  for (std::size_t j = 0; j <= n; ++j) out(n, j) = row[j];
  return out;
}

/// Of Newton's last step, relative; the error is of its square. In double it is above rounding even next to doublings.
inline double converged_step(double) { return 1e-11; }
inline Quad converged_step(Quad) { return Quad(1e-29); }

/// Newton's method; nothing if it does not converge. Steps that no longer become smaller are accepted a little above the
/// tolerance: they are rounding, and more of it where the equations are nearly singular.
template <class Real>
std::optional<Values<Real>> corrected(const Frame& frame, Values<Real> y, const Constraint<Real>& constraint, int most = 12,
                                      Real tolerance = converged_step(Real(0))) {
  const std::size_t n = frame.size();
  Real last(1);
  for (int k = 0; k < most; ++k) {
    Values<Real> step = residual(frame, y);
    Real sum = -constraint.value;
    for (std::size_t j = 0; j <= n; ++j) sum += constraint.row[j] * y[j];
    step.push_back(sum);
    if (solve(bordered(frame, y, constraint.row), step) == Real(0)) return std::nullopt;
    Real size(0);
    for (std::size_t j = 0; j <= n; ++j) {
      y[j] -= step[j];
      size = std::max(size, magnitude(step[j]) / (Real(1) + magnitude(y[j])));
    }
    if (!(size < Real(1e3))) return std::nullopt;
    if (size < tolerance || (size < Real(1e3) * tolerance && size > Real(0.5) * last)) return y;
    last = size;
  }
  return std::nullopt;
}

/// M = product of S_i Phi_i. Its trace and determinant, with the jump of states S = [-k_r, 0; (a+ + k_r a-)/v, -k_r].
template <class Real> struct Invariants { Real trace, determinant; };

template <class Real> Invariants<Real> monodromy(const Frame& frame, const Values<Real>& y) {
  const Parameters<Real> q = frame.at(y[frame.size()]);
  Transition<Real> M{Real(1), Real(0), Real(0), Real(1)};
  for (int i = 0; i < frame.impacts; ++i) {
    const std::size_t k = 2 * static_cast<std::size_t>(i);
    const Real v = y[k + 1], before = acceleration(q, y[k], Motion<Real>{q[R], v});
    const Real after = acceleration(q, y[k], Motion<Real>{q[R], -q[K_R] * v}), low = (after + q[K_R] * before) / v;
    const Transition<Real> jumped = {-q[K_R] * M.xx, -q[K_R] * M.xv, low * M.xx - q[K_R] * M.vx, low * M.xv - q[K_R] * M.vv};
    const Transition<Real> over = transition(q, leg(frame, y, i).duration);
    const Motion<Real> first = over * Motion<Real>{jumped.xx, jumped.vx}, second = over * Motion<Real>{jumped.xv, jumped.vv};
    M = {first.x, second.x, first.v, second.v};
  }
  return {M.xx + M.vv, M.xx * M.vv - M.xv * M.vx};
}

}  // namespace graze::reference
