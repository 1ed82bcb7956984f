// SPDX-License-Identifier: GPL-3.0-or-later
// Systems that are not the one-barrier oscillator, for tests: nothing in the library may be written for two states, one barrier
// or a forcing. All dimensionless; all derivatives by hand and checked in tests/lib/other_systems.cpp.
//
//   two_mass_oscillator    4 states, forced, two rigid barriers, one per mass (both may be struck at the same instant)
//   two_sided_oscillator   2 states, forced, symmetric barriers at -r and +r, rigid or elastic: symmetry breaking (BP); rigid,
//                          xi = 2 and the rest by default: at eta = 1.5299072088081 (closed form: two_sided_orbit.hpp)
//   driven_self_excited    4 states, forced: an impact oscillator driving a van der Pol oscillator: Neimark-Sacker (NS); by
//                          default in mu at mu = 0 exactly, multipliers exp(+-i omega T); with epsilon = 0.2 near mu = 0.164
//   bouncing_ball          2 states, autonomous, chattering in closed form
//   van_der_pol_stop       2 states, autonomous limit cycle with one impact: trivial multiplier
//   relay_feedback         3 states, autonomous, discontinuous field, two modes: limit cycle in closed form
#pragma once

#include <graze/lib/hybrid_system.hpp>

#include <cmath>
#include <limits>

namespace graze::support {

namespace detail {

inline constexpr double infinity = std::numeric_limits<double>::infinity();

inline ParameterInfo parameter(std::string name, double value, double lower = -infinity, bool open = false,
                               double upper = infinity) {
  return {std::move(name), value, lower, upper, open, "dimensionless", ""};
}

/// Guard and reset of x[position]'s rigid stop at p[level], approached with sign * speed > 0: speed -> -p[restitution] speed.
inline Event rigid_stop(std::string name, Eigen::Index position, std::size_t level, std::size_t restitution, double sign) {
  const Eigen::Index speed = position + 1, wall = static_cast<Eigen::Index>(level), k_r = static_cast<Eigen::Index>(restitution);
  Event event;
  event.name = std::move(name);
  event.kind = EventKind::impact;
  event.guard = make_level_guard({.coordinate = static_cast<std::size_t>(position), .level = level, .sign = sign});
  event.reset.map = [=](double, const Vector& x, const Vector& p, Vector& out) {
    out = x;
    out[position] = p[wall];
    out[speed] = -p[k_r] * x[speed];
  };
  event.reset.dx = [=](double, const Vector&, const Vector& p, Matrix& J) {
    J.setIdentity();
    J(position, position) = 0.0;
    J(speed, speed) = -p[k_r];
  };
  event.reset.dp = [=](double, const Vector& x, const Vector&, Matrix& J) {
    J.setZero();
    J(position, wall) = 1.0;
    J(speed, k_r) = -x[speed];
  };
  event.log_volume_change = [=](const Vector& p) { return 2.0 * std::log(p[k_r]); };
  return event;
}

}  // namespace detail

/// x1'' + 2 b x1' + x1 + kappa (x1 - x2) = xi cos(eta t),  mu x2'' + 2 b x2' + x2 + kappa (x2 - x1) = 0,  x1 <= r1, x2 <= r2.
/// State (x1, x1', x2, x2'); parameters b, kappa, mu, xi, eta, r1, r2, k_r. With mu = 1 and both masses started alike without
/// forcing they move as one, and strike at the same instant if r1 = r2.
inline HybridSystem two_mass_oscillator() {
  enum : Eigen::Index { b, kappa, mu, xi, eta, r1, r2, k_r };
  using detail::parameter;
  HybridSystem system;
  system.name = "two-mass";
  system.states = 4;
  system.parameters = {parameter("b", 0.05, 0.0),
                       parameter("kappa", 0.5, 0.0),
                       parameter("mu", 0.8, 0.0, true),
                       parameter("xi", 1.0),
                       parameter("eta", 0.9, 0.0, true),
                       parameter("r1", 1.0),
                       parameter("r2", 1.2),
                       parameter("k_r", 0.8, 0.0, false, 1.0)};
  system.forcing_frequency = eta;
  Mode mode;
  mode.name = "free";
  mode.field = [](double t, const Vector& x, const Vector& p, Vector& f) {
    f[0] = x[1];
    f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - x[0] - p[kappa] * (x[0] - x[2]);
    f[2] = x[3];
    f[3] = (-2.0 * p[b] * x[3] - x[2] - p[kappa] * (x[2] - x[0])) / p[mu];
  };
  mode.field_dx = [](double, const Vector&, const Vector& p, Matrix& J) {
    J << 0.0, 1.0, 0.0, 0.0,                                                     //
        -1.0 - p[kappa], -2.0 * p[b], p[kappa], 0.0,                             //
        0.0, 0.0, 0.0, 1.0,                                                      //
        p[kappa] / p[mu], 0.0, (-1.0 - p[kappa]) / p[mu], -2.0 * p[b] / p[mu];  //
  };
  mode.field_dp = [](double t, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(1, b) = -2.0 * x[1];
    J(3, b) = -2.0 * x[3] / p[mu];
    J(1, kappa) = x[2] - x[0];
    J(3, kappa) = (x[0] - x[2]) / p[mu];
    J(3, mu) = (2.0 * p[b] * x[3] + x[2] + p[kappa] * (x[2] - x[0])) / (p[mu] * p[mu]);
    J(1, xi) = std::cos(p[eta] * t);
    J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
  };
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f.setZero();
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
  };
  system.modes = {mode};
  system.events = {detail::rigid_stop("impact-1", 0, r1, k_r, 1.0), detail::rigid_stop("impact-2", 2, r2, k_r, 1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] > p[r1] || x[2] > p[r2]) return std::nullopt;
    return 0;
  };
  return system;
}

/// x'' + 2 b x' + x + F(x) = xi cos(eta t) between barriers at -r and +r: rigid (x'+ = -k_r x'-) or elastic
/// (F = k_S (|x| - r) sign x beyond them). State (x, x'); parameters b, xi, eta, r, then k_r (rigid) or k_S (elastic).
/// Symmetric under (x, t) -> (-x, t + T/2): symmetric orbits of period 1 lose their symmetry in pitchforks (BP), never in PD.
/// The guard of the barrier at -r is not a level of a parameter, so that the general flow carries the motion.
inline HybridSystem two_sided_oscillator(bool rigid) {
  enum : Eigen::Index { b, xi, eta, r, k };
  using detail::parameter;
  HybridSystem system;
  system.name = rigid ? "two-sided-rigid" : "two-sided-elastic";
  system.states = 2;
  system.parameters = {parameter("b", 0.05, 0.0), parameter("xi", 1.0), parameter("eta", 0.9, 0.0, true),
                       parameter("r", 1.0, 0.0, true),
                       rigid ? parameter("k_r", 0.8, 0.0, false, 1.0) : parameter("k_S", 25.0, 0.0, true)};
  system.forcing_frequency = eta;
  // side: -1, 0 (free), +1.
  const auto mode_of = [](std::string name, double side) {
    Mode mode;
    mode.name = std::move(name);
    mode.field = [side](double t, const Vector& x, const Vector& p, Vector& f) {
      f[0] = x[1];
      f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - x[0];
      if (side != 0.0) f[1] -= p[k] * (x[0] - side * p[r]);
    };
    mode.field_dx = [side](double, const Vector&, const Vector& p, Matrix& J) {
      J << 0.0, 1.0, -1.0 - (side != 0.0 ? p[k] : 0.0), -2.0 * p[b];
    };
    mode.field_dp = [side](double t, const Vector& x, const Vector& p, Matrix& J) {
      J.setZero();
      J(1, b) = -2.0 * x[1];
      J(1, xi) = std::cos(p[eta] * t);
      J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
      if (side != 0.0) {
        J(1, r) = side * p[k];
        J(1, k) = -(x[0] - side * p[r]);
      }
    };
    mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
      f << 0.0, -p[xi] * p[eta] * std::sin(p[eta] * t);
    };
    return mode;
  };
  // Guard h = sign (x - side r).
  const auto guard_of = [](double sign, double side) {
    Guard guard;
    guard.value = [=](double, const Vector& x, const Vector& p) { return sign * (x[0] - side * p[r]); };
    guard.dx = [=](double, const Vector&, const Vector&, Vector& g) { g << sign, 0.0; };
    guard.dp = [=](double, const Vector&, const Vector&, Vector& g) {
      g.setZero();
      g[r] = -sign * side;
    };
    return guard;
  };
  system.modes = {mode_of("free", 0.0)};
  if (rigid) {
    Event upper = detail::rigid_stop("impact-upper", 0, r, k, 1.0), lower = upper;
    lower.name = "impact-lower";
    lower.guard = guard_of(-1.0, -1.0);
    lower.reset.map = [](double, const Vector& x, const Vector& p, Vector& out) { out << -p[r], -p[k] * x[1]; };
    lower.reset.dp = [](double, const Vector& x, const Vector&, Matrix& J) {
      J.setZero();
      J(0, r) = -1.0;
      J(1, k) = -x[1];
    };
    system.events = {upper, lower};
    system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
      if (std::abs(x[0]) > p[r]) return std::nullopt;
      return 0;
    };
    return system;
  }
  system.modes.push_back(mode_of("upper", 1.0));
  system.modes.push_back(mode_of("lower", -1.0));
  const auto event_of = [&](std::string name, std::size_t from, std::size_t to, EventKind kind, double sign, double side) {
    Event event;
    event.name = std::move(name);
    event.from = from;
    event.to = to;
    event.kind = kind;
    event.continuous = true;
    event.guard = guard_of(sign, side);
    return event;
  };
  system.events = {event_of("enter-upper", 0, 1, EventKind::enter, 1.0, 1.0),
                   event_of("enter-lower", 0, 2, EventKind::enter, -1.0, -1.0),
                   event_of("leave-upper", 1, 0, EventKind::leave, -1.0, 1.0),
                   event_of("leave-lower", 2, 0, EventKind::leave, 1.0, -1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] > p[r] || (x[0] == p[r] && x[1] > 0.0)) return 1;
    if (x[0] < -p[r] || (x[0] == -p[r] && x[1] < 0.0)) return 2;
    return 0;
  };
  return system;
}

/// x'' + 2 b x' + x = xi cos(eta t), x <= r rigid (k_r), driving y'' - (mu - y^2) y' + omega^2 y = epsilon x.
/// State (x, x', y, y'); parameters b, xi, eta, r, k_r, mu, omega, epsilon. At epsilon = 0 and y = 0 two multipliers of a
/// period-n orbit are exactly exp((mu/2 +- i sqrt(omega^2 - mu^2/4)) n T): Neimark-Sacker at mu = 0. At epsilon != 0 it lies
/// near mu = mean of y^2.
inline HybridSystem driven_self_excited() {
  enum : Eigen::Index { b, xi, eta, r, k_r, mu, omega, epsilon };
  using detail::parameter;
  HybridSystem system;
  system.name = "driven-self-excited";
  system.states = 4;
  system.parameters = {parameter("b", 0.05, 0.0),  parameter("xi", 1.0), parameter("eta", 0.8, 0.0, true), parameter("r", 1.0),
                       parameter("k_r", 0.6, 0.0, false, 1.0), parameter("mu", -0.1), parameter("omega", 0.55, 0.0, true),
                       parameter("epsilon", 0.0)};
  system.forcing_frequency = eta;
  Mode mode;
  mode.name = "free";
  mode.field = [](double t, const Vector& x, const Vector& p, Vector& f) {
    f[0] = x[1];
    f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - x[0];
    f[2] = x[3];
    f[3] = (p[mu] - x[2] * x[2]) * x[3] - p[omega] * p[omega] * x[2] + p[epsilon] * x[0];
  };
  mode.field_dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(0, 1) = J(2, 3) = 1.0;
    J(1, 0) = -1.0;
    J(1, 1) = -2.0 * p[b];
    J(3, 0) = p[epsilon];
    J(3, 2) = -2.0 * x[2] * x[3] - p[omega] * p[omega];
    J(3, 3) = p[mu] - x[2] * x[2];
  };
  mode.field_dp = [](double t, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(1, b) = -2.0 * x[1];
    J(1, xi) = std::cos(p[eta] * t);
    J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
    J(3, mu) = x[3];
    J(3, omega) = -2.0 * p[omega] * x[2];
    J(3, epsilon) = x[0];
  };
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f.setZero();
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
  };
  system.modes = {mode};
  system.events = {detail::rigid_stop("impact", 0, r, k_r, 1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] > p[r]) return std::nullopt;
    return 0;
  };
  return system;
}

/// x'' = -g above a floor at x = floor, speed -> -k_r speed there, at rest on it in the end. State (x, x'); parameters g, floor,
/// k_r. Dropped from height H above the floor it comes to rest after sqrt(2 H/g) (1 + k_r)/(1 - k_r).
inline HybridSystem bouncing_ball() {
  enum : Eigen::Index { g, floor, k_r };
  using detail::parameter;
  HybridSystem system;
  system.name = "bouncing-ball";
  system.states = 2;
  system.parameters = {parameter("g", 9.81, 0.0, true), parameter("floor", 0.0), parameter("k_r", 0.8, 0.0, false, 1.0)};
  Mode flying, resting;
  flying.name = "flying";
  flying.field = [](double, const Vector& x, const Vector& p, Vector& f) { f << x[1], -p[g]; };
  flying.field_dx = [](double, const Vector&, const Vector&, Matrix& J) { J << 0.0, 1.0, 0.0, 0.0; };
  flying.field_dp = [](double, const Vector&, const Vector&, Matrix& J) {
    J.setZero();
    J(1, g) = -1.0;
  };
  resting.name = "resting";
  resting.field = [](double, const Vector&, const Vector&, Vector& f) { f.setZero(); };
  resting.field_dx = resting.field_dp = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  system.modes = {flying, resting};
  Event bounce = detail::rigid_stop("bounce", 0, floor, k_r, -1.0);
  Accumulation rest;
  rest.sticking_mode = 1;
  rest.reset.map = [](double, const Vector&, const Vector& p, Vector& out) { out << p[floor], 0.0; };
  rest.reset.dx = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  rest.reset.dp = [](double, const Vector&, const Vector&, Matrix& J) {
    J.setZero();
    J(0, floor) = 1.0;
  };
  bounce.accumulation = rest;
  system.events = {bounce};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] < p[floor]) return std::nullopt;
    return x[0] == p[floor] && x[1] == 0.0 ? 1 : 0;
  };
  return system;
}

/// x'' - mu (1 - x^2) x' + x = 0 with a rigid stop x <= r. State (x, x'); parameters mu, r, k_r. For 0 < r < 2 the limit cycle
/// strikes the stop once a turn; it has one trivial multiplier.
inline HybridSystem van_der_pol_stop() {
  enum : Eigen::Index { mu, r, k_r };
  using detail::parameter;
  HybridSystem system;
  system.name = "van-der-pol-stop";
  system.states = 2;
  system.parameters = {parameter("mu", 0.5), parameter("r", 1.2), parameter("k_r", 0.9, 0.0, false, 1.0)};
  Mode mode;
  mode.name = "free";
  mode.field = [](double, const Vector& x, const Vector& p, Vector& f) {
    f << x[1], p[mu] * (1.0 - x[0] * x[0]) * x[1] - x[0];
  };
  mode.field_dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J << 0.0, 1.0, -2.0 * p[mu] * x[0] * x[1] - 1.0, p[mu] * (1.0 - x[0] * x[0]);
  };
  mode.field_dp = [](double, const Vector& x, const Vector&, Matrix& J) {
    J.setZero();
    J(1, mu) = (1.0 - x[0] * x[0]) * x[1];
  };
  system.modes = {mode};
  system.events = {detail::rigid_stop("impact", 0, r, k_r, 1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] > p[r]) return std::nullopt;
    return 0;
  };
  return system;
}

/// A relay with hysteresis around a third-order lag: x1' = a (x2 - x1), x2' = a (x3 - x2), x3' = a (u - x3), u = -gain in mode
/// "down" until x1 falls to -w, u = +gain in mode "up" until x1 rises to w. State (x1, x2, x3); parameters a, gain, w.
/// Symmetric limit cycle: over half its period x goes into -x, so that x(0) = (I + e^{A h})^{-1} (integral of e^{A s} B u ds).
inline HybridSystem relay_feedback() {
  enum : Eigen::Index { a, gain, w };
  using detail::parameter;
  HybridSystem system;
  system.name = "relay-feedback";
  system.states = 3;
  system.parameters = {parameter("a", 1.0, 0.0, true), parameter("gain", 1.0, 0.0, true), parameter("w", 0.05, 0.0, true)};
  const auto mode_of = [](std::string name, double sign) {
    Mode mode;
    mode.name = std::move(name);
    mode.field = [sign](double, const Vector& x, const Vector& p, Vector& f) {
      f << p[a] * (x[1] - x[0]), p[a] * (x[2] - x[1]), p[a] * (sign * p[gain] - x[2]);
    };
    mode.field_dx = [](double, const Vector&, const Vector& p, Matrix& J) {
      J << -p[a], p[a], 0.0, 0.0, -p[a], p[a], 0.0, 0.0, -p[a];
    };
    mode.field_dp = [sign](double, const Vector& x, const Vector& p, Matrix& J) {
      J.setZero();
      J.col(a) << x[1] - x[0], x[2] - x[1], sign * p[gain] - x[2];
      J(2, gain) = sign * p[a];
    };
    return mode;
  };
  system.modes = {mode_of("up", 1.0), mode_of("down", -1.0)};
  const auto switch_of = [](std::string name, std::size_t from, std::size_t to, double sign) {
    Event event;
    event.name = std::move(name);
    event.from = from;
    event.to = to;
    event.guard.value = [sign](double, const Vector& x, const Vector& p) { return sign * x[0] - p[w]; };
    event.guard.dx = [sign](double, const Vector&, const Vector&, Vector& g) { g << sign, 0.0, 0.0; };
    event.guard.dp = [](double, const Vector&, const Vector&, Vector& g) {
      g.setZero();
      g[w] = -1.0;
    };
    return event;
  };
  system.events = {switch_of("switch-down", 0, 1, 1.0), switch_of("switch-up", 1, 0, -1.0)};
  system.initial_mode = [](double, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    return x[0] < p[w] ? 0 : 1;
  };
  return system;
}

}  // namespace graze::support
