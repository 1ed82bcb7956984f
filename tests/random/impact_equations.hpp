// SPDX-License-Identifier: GPL-3.0-or-later
// The equations of orbits with m impacts in n forcing periods, and of their families in a parameter p, in the coordinates of
// the events. The unknowns are p and, for each impact, a block (phi, w) of its phase and approach speed. A second mass adds to
// the block its coordinate and velocity before the impact, which the wall does not fix. Let z(block) be the state before the
// impact:
//
//     flight from the rebound of z(block_i) at phi_i to phi_{i+1} = z(block_{i+1}),     phi_{m+1} = phi_1 + 2 pi n
//
// The equations are smooth through w_i = 0. Let A_i, B_i be the derivatives by block_i and block_{i+1}, and J(kappa) their
// cyclic matrix with kappa B_m in its corner. A multiplier +1 (fold) is det J(1) = 0, a multiplier -1 (doubling) is det J(-1)
// = 0. The impact speeds, which make the conditions on the multipliers themselves singular, are divided out. B is singular at
// w = 0, J is not.
//
// A symmetric orbit between equal stops, (phi + pi n, -x) = (phi, x) with n odd, is given by one half of it: the mirror image
// of a block has the same w at the other stop. The equations close with that image after pi n, and det J(-1) = 0 is a
// multiplier +1 of the whole orbit: the symmetry breaks (BP).
#pragma once

#include "linear.hpp"

#include <algorithm>
#include <optional>

namespace graze::reference {

/// The constants of a family: all parameters except one, the periods, and the stops in the order of the impacts.
struct Frame {
  Model model = Model::barrier;
  Parameters<double> base{};
  std::size_t name = ETA;  ///< of the parameter that changes
  int periods = 1;
  std::vector<int> stops = {0};  ///< for a symmetric orbit those of one half
  bool half = false;             ///< a symmetric orbit
  std::size_t block() const { return is_chain(model) ? 4 : 2; }
  std::size_t legs() const { return stops.size(); }
  std::size_t size() const { return block() * legs(); }
  int impacts() const { return static_cast<int>(stops.size()) * (half ? 2 : 1); }
  /// Phase from one end of the equations to the other.
  template <class Real> Real turn() const { return Real((half ? 1 : 2) * periods) * pi<Real>(); }
  /// Stop of impact i; i = legs() is the first one again, or its mirror image.
  int stop(std::size_t i) const { return i < legs() ? stops[i] : half ? 1 - stops[i - legs()] : stops[i - legs()]; }
  template <class Real> Parameters<Real> at(Real value) const {
    Parameters<Real> q = converted<Real>(base);
    q[name] = value;
    return q;
  }
  template <class Real> Linear<Real> system(Real value) const { return linear(model, at(value)); }
};

/// The state before the impact with this block. A derivative (by an entry that is 1) has no wall.
template <class Real>
Point<Real> before_impact(const Linear<Real>& system, const Stop<Real>& stop, const Real* block, Real wall) {
  const std::size_t a = stop.bound(), b = stop.free();
  Point<Real> z{};
  if (system.chain) {
    z[b] = block[2];
    z[b + 2] = block[3];
  }
  z[a] = (wall - stop.row[b] * z[b]) / stop.row[a];
  z[a + 2] = (block[1] - stop.row[b] * z[b + 2]) / stop.row[a];
  return z;
}

template <class Real>
Values<Real> block_of(const Linear<Real>& system, const Stop<Real>& stop, Real phase, const Point<Real>& z) {
  if (!system.chain) return {phase, stop.speed(z)};
  return {phase, stop.speed(z), z[stop.free()], z[stop.free() + 2]};
}

template <class Real> using Derivatives = std::array<Point<Real>, 4>;

/// Derivatives of the state before an impact by its block, except the phase.
template <class Real> Derivatives<Real> by_block(const Linear<Real>& system, const Stop<Real>& stop) {
  Derivatives<Real> out{};
  for (std::size_t c = 1; c < system.size(); ++c) {
    std::array<Real, 4> block{};
    block[c] = Real(1);
    out[c] = before_impact(system, stop, block.data(), Real(0));
  }
  return out;
}

/// The flight from one impact to the next, and the derivatives of its end.
template <class Real> struct Leg {
  Linear<Real> system;
  Stop<Real> from, to;
  Real phase, duration;
  Point<Real> before, start, end;
  Square<Real> over;
  Derivatives<Real> by_start, by_end;  ///< of the end minus z(next block), by both blocks
  Real end_phase() const { return phase + system.q[ETA] * duration; }
};

template <class Real> Leg<Real> leg(const Frame& frame, const Values<Real>& y, std::size_t i) {
  const std::size_t k = frame.block() * i, next = i + 1 == frame.legs() ? 0 : k + frame.block();
  Leg<Real> out;
  out.system = frame.system(y[frame.size()]);
  const Linear<Real>& system = out.system;
  out.from = system.stops[static_cast<std::size_t>(frame.stop(i))];
  out.to = system.stops[static_cast<std::size_t>(frame.stop(i + 1))];
  out.phase = y[k];
  const Real there = y[next] + (next == 0 ? frame.turn<Real>() : Real(0)), eta = system.q[ETA];
  out.duration = (there - y[k]) / eta;
  out.before = before_impact(system, out.from, &y[k], out.from.wall);
  out.start = out.from.rebound(out.before);
  out.over = transition(system, out.duration);
  out.end = plus(impactless(system, there), Real(1), out.over * plus(out.start, Real(-1), impactless(system, out.phase)));
  out.by_start = by_block(system, out.from);
  for (Point<Real>& by : out.by_start) by = out.over * out.from.rebound(by);
  out.by_start[0] = plus(Point<Real>{}, Real(-1) / eta, out.over * rate(system, out.phase, out.start));
  out.by_end = by_block(system, out.to);
  for (Point<Real>& by : out.by_end) by = plus(Point<Real>{}, Real(-1), by);
  out.by_end[0] = plus(Point<Real>{}, Real(1) / eta, rate(system, there, out.end));
  return out;
}

template <class Real> Values<Real> residual(const Frame& frame, const Values<Real>& y) {
  Values<Real> out;
  for (std::size_t i = 0; i < frame.legs(); ++i) {
    const Leg<Real> here = leg(frame, y, i);
    const std::size_t next = i + 1 == frame.legs() ? 0 : frame.block() * (i + 1);
    const Point<Real> off = plus(here.end, Real(-1), before_impact(here.system, here.to, &y[next], here.to.wall));
    for (std::size_t k = 0; k < frame.block(); ++k) out.push_back(off[here.system.index(k)]);
  }
  return out;
}

/// J(kappa), square.
template <class Real> Table<Real> jacobian(const Frame& frame, const Values<Real>& y, Real kappa) {
  Table<Real> J(frame.size(), frame.size());
  const std::size_t n = frame.block();
  for (std::size_t i = 0; i < frame.legs(); ++i) {
    const Leg<Real> here = leg(frame, y, i);
    const std::size_t k = n * i, next = i + 1 == frame.legs() ? 0 : k + n;
    const Real factor = next == 0 ? kappa : Real(1);
    for (std::size_t row = 0; row < n; ++row)
      for (std::size_t c = 0; c < n; ++c) {
        J(k + row, k + c) += here.by_start[c][here.system.index(row)];
        J(k + row, next + c) += factor * here.by_end[c][here.system.index(row)];
      }
  }
  return J;
}

/// Step of the central difference in p: its error, of second order, is the root of rounding.
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

/// One linear equation for y in addition to those of the orbit: row . y = value.
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

/// The Jacobian by y, p included, with the row of the constraint below.
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

/// Relative tolerance of Newton's last step; the error is its square. In double it is above rounding even near doublings.
inline double converged_step(double) { return 1e-11; }
inline Quad converged_step(Quad) { return Quad(1e-29); }

/// Newton's method; nothing if it does not converge. Steps that no longer decrease are accepted a little above the tolerance:
/// they are rounding, which is larger where the equations are nearly singular.
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

/// M = product of exp(A duration) S over the impacts, with the jump of states S = R + (rate+ - R rate-) row / w; R is the
/// rebound. For half a symmetric orbit, M^2 is the matrix of the whole.
template <class Real> Table<Real> monodromy(const Frame& frame, const Values<Real>& y) {
  Square<Real> M{};
  for (std::size_t i = 0; i < 4; ++i) M[i][i] = Real(frame.half ? -1 : 1);
  for (std::size_t i = 0; i < frame.legs(); ++i) {
    const Leg<Real> here = leg(frame, y, i);
    const Point<Real> jump =
        plus(rate(here.system, here.phase, here.start), Real(-1), here.from.rebound(rate(here.system, here.phase, here.before)));
    Square<Real> columns{};
    for (std::size_t j = 0; j < 4; ++j) {
      Point<Real> column;
      for (std::size_t k = 0; k < 4; ++k) column[k] = M[k][j];
      const Real touched = here.from.row[0] * column[0] + here.from.row[1] * column[1];
      column = here.over * plus(here.from.rebound(column), touched / here.from.speed(here.before), jump);
      for (std::size_t k = 0; k < 4; ++k) columns[k][j] = column[k];
    }
    M = columns;
  }
  const Linear<Real> system = frame.system(y[frame.size()]);
  Table<Real> out(frame.block(), frame.block());
  for (std::size_t i = 0; i < out.rows; ++i)
    for (std::size_t j = 0; j < out.rows; ++j) out(i, j) = M[system.index(i)][system.index(j)];
  return out;
}

/// det(M - mu I)
template <class Real> Real characteristic(Table<Real> M, Real mu) {
  for (std::size_t i = 0; i < M.rows; ++i) M(i, i) -= mu;
  Values<Real> unused(M.rows, Real(0));
  return solve(M, unused);
}

/// Product over all pairs of (product of two multipliers - 1), from the minors of order 2. It is 0 at a Neimark-Sacker point.
template <class Real> Real pair_condition(const Table<Real>& M) {
  constexpr std::array<std::array<std::size_t, 2>, 6> pairs = {{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
  Table<Real> minors(6, 6);
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      minors(i, j) =
          M(pairs[i][0], pairs[j][0]) * M(pairs[i][1], pairs[j][1]) - M(pairs[i][0], pairs[j][1]) * M(pairs[i][1], pairs[j][0]);
  return characteristic(minors, Real(1));
}

/// Sums of the powers 1 ... n of the multipliers.
template <class Real> Values<Real> power_sums(const Table<Real>& M) {
  Values<Real> out;
  Table<Real> power = M;
  for (std::size_t k = 0; k < M.rows; ++k) {
    Real trace(0);
    for (std::size_t i = 0; i < M.rows; ++i) trace += power(i, i);
    out.push_back(trace);
    power = power * M;
  }
  return out;
}

/// If two multipliers have the product 1: whether they are a complex pair. Their sum s follows from the coefficients of the
/// characteristic polynomial, e_3 = s e_4 + (e_1 - s).
template <class Real> bool on_circle(const Table<Real>& M) {
  const Values<Real> p = power_sums(M);
  const Real e1 = p[0], e2 = (e1 * p[0] - p[1]) / Real(2), e3 = (e2 * p[0] - e1 * p[1] + p[2]) / Real(3);
  const Real s = (e3 - e1) / (characteristic(M, Real(0)) - Real(1));
  return magnitude(s) < Real(2);
}

}  // namespace graze::reference
