// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/hand_written.hpp"

#include <cmath>

namespace graze::support {

namespace {

using namespace oscillator_parameter;

Mode free_mode() {
  Mode mode;
  mode.name = "free";
  mode.field = [](double t, const Vector& x, const Vector& p, Vector& f) {
    f[0] = x[1];
    f[1] = p[xi] * std::cos(p[eta] * t) - 2.0 * p[b] * x[1] - x[0] - p[beta] * x[0] * x[0] * x[0];
  };
  mode.field_dx = [](double, const Vector& x, const Vector& p, Matrix& J) {
    J << 0.0, 1.0, -1.0 - 3.0 * p[beta] * x[0] * x[0], -2.0 * p[b];
  };
  mode.field_dp = [](double t, const Vector& x, const Vector& p, Matrix& J) {
    J.setZero();
    J(1, b) = -2.0 * x[1];
    J(1, beta) = -x[0] * x[0] * x[0];
    J(1, xi) = std::cos(p[eta] * t);
    J(1, eta) = -p[xi] * t * std::sin(p[eta] * t);
  };
  mode.field_dt = [](double t, const Vector&, const Vector& p, Vector& f) {
    f[0] = 0.0;
    f[1] = -p[xi] * p[eta] * std::sin(p[eta] * t);
  };
  mode.structure = [](const Vector& p) -> ModeStructure {
    if (p[beta] != 0.0) {
      using C = CubicOscillator;
      C cubic{{p[b], 1.0, p[beta], p[xi], p[eta], 0.0}, Matrix::Zero(C::count, p.size())};
      cubic.dp(C::damping, b) = cubic.dp(C::cubic, beta) = cubic.dp(C::amplitude, xi) = cubic.dp(C::frequency, eta) = 1.0;
      return cubic;
    }
    LinearOscillator linear;
    linear.damping = p[b];
    linear.amplitude = p[xi];
    linear.frequency = p[eta];
    linear.dp = Matrix::Zero(5, p.size());
    linear.dp(0, b) = linear.dp(2, xi) = linear.dp(3, eta) = 1.0;
    linear.not_differentiable_in = {beta};
    return linear;
  };
  return mode;
}

void attach_soft_contact(HybridSystem& system, Mode contact) {
  static constexpr std::size_t free = 0, in_contact = 1;
  contact.name = "contact";
  system.modes.push_back(std::move(contact));
  Event enter;
  enter.name = "enter";
  enter.from = free;
  enter.to = in_contact;
  enter.kind = EventKind::enter;
  enter.continuous = true;
  enter.guard = make_level_guard({.coordinate = 0, .level = r, .sign = 1.0});
  Event leave = enter;
  leave.name = "leave";
  leave.from = in_contact;
  leave.to = free;
  leave.kind = EventKind::leave;
  leave.guard = make_level_guard({.coordinate = 0, .level = r, .sign = -1.0});
  system.events.push_back(std::move(enter));
  system.events.push_back(std::move(leave));
  system.initial_mode = [](double t, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    const double gap = x[0] - p[r];
    if (gap != 0.0) return gap > 0.0 ? in_contact : free;
    if (x[1] != 0.0) return x[1] > 0.0 ? in_contact : free;
    return barrier_acceleration(t, p) > 0.0 ? in_contact : free;
  };
}

constexpr std::size_t k_H = law, b_H = law + 1;

/// Depth, clipped so that a stage just outside the contact does not take the root of a negative number.
double root_depth(const Vector& x, const Vector& p) { return std::sqrt(std::max(0.0, x[0] - p[r])); }

void attach_hertz(HybridSystem& system) {
  const Mode free = system.modes.front();
  Mode contact = free;
  contact.field = [free](double t, const Vector& x, const Vector& p, Vector& f) {
    free.field(t, x, p, f);
    const double y = root_depth(x, p);
    f[1] -= p[k_H] * y * y * y * (1.0 + p[b_H] * x[1]);
  };
  contact.field_dx = [free](double t, const Vector& x, const Vector& p, Matrix& J) {
    free.field_dx(t, x, p, J);
    const double y = root_depth(x, p);
    J(1, 0) -= 1.5 * p[k_H] * y * (1.0 + p[b_H] * x[1]);
    J(1, 1) -= p[k_H] * y * y * y * p[b_H];
  };
  contact.field_dp = [free](double t, const Vector& x, const Vector& p, Matrix& J) {
    free.field_dp(t, x, p, J);
    const double y = root_depth(x, p);
    J(1, r) += 1.5 * p[k_H] * y * (1.0 + p[b_H] * x[1]);
    J(1, k_H) = -y * y * y * (1.0 + p[b_H] * x[1]);
    J(1, b_H) = -p[k_H] * y * y * y * x[1];
  };
  contact.structure = [](const Vector& p) -> ModeStructure {
    HertzContact hertz;
    hertz.dp = Matrix::Zero(HertzContact::count, p.size());
    const std::size_t parameter[] = {b, beta, xi, eta, r, k_H, b_H};
    for (Eigen::Index i = 0; i < hertz.dp.rows(); ++i) {
      hertz.value[static_cast<std::size_t>(i)] = p[static_cast<Eigen::Index>(parameter[i])];
      hertz.dp(i, static_cast<Eigen::Index>(parameter[i])) = 1.0;
    }
    return hertz;
  };
  attach_soft_contact(system, std::move(contact));
}

constexpr std::size_t k_S = law;

void attach_linear(HybridSystem& system) {
  const Mode free = system.modes.front();
  Mode contact = free;
  contact.field = [free](double t, const Vector& x, const Vector& p, Vector& f) {
    free.field(t, x, p, f);
    f[1] -= p[k_S] * (x[0] - p[r]);
  };
  contact.field_dx = [free](double t, const Vector& x, const Vector& p, Matrix& J) {
    free.field_dx(t, x, p, J);
    J(1, 0) -= p[k_S];
  };
  contact.field_dp = [free](double t, const Vector& x, const Vector& p, Matrix& J) {
    free.field_dp(t, x, p, J);
    J(1, r) += p[k_S];
    J(1, k_S) = -(x[0] - p[r]);
  };
  contact.structure = [free](const Vector& p) -> ModeStructure {
    ModeStructure structure = free.structure(p);
    if (auto* linear = std::get_if<LinearOscillator>(&structure)) {
      linear->stiffness += p[k_S];
      linear->constant = p[k_S] * p[r];
      linear->dp(1, k_S) = 1.0;
      linear->dp(4, k_S) = p[r];
      linear->dp(4, r) = p[k_S];
    } else if (auto* cubic = std::get_if<CubicOscillator>(&structure)) {
      using C = CubicOscillator;
      cubic->value[C::stiffness] += p[k_S];
      cubic->value[C::constant] = p[k_S] * p[r];
      cubic->dp(C::stiffness, k_S) = 1.0;
      cubic->dp(C::constant, k_S) = p[r];
      cubic->dp(C::constant, r) = p[k_S];
    }
    return structure;
  };
  attach_soft_contact(system, std::move(contact));
}

constexpr std::size_t k_r = law;
constexpr std::size_t free_flight = 0, held = 1;

Mode held_mode() {
  Mode mode;
  mode.name = "held";
  mode.field = [](double, const Vector&, const Vector&, Vector& f) { f.setZero(); };
  mode.field_dx = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  mode.field_dp = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  return mode;
}

Event impact() {
  Event event;
  event.name = "impact";
  event.from = event.to = free_flight;
  event.kind = EventKind::impact;
  event.guard = make_level_guard({.coordinate = 0, .level = r, .sign = 1.0});
  event.reset = make_rebound({.level = r, .coefficient = k_r});
  event.log_volume_change = [](const Vector& p) { return 2.0 * std::log(p[k_r]); };
  Accumulation rest;
  rest.sticking_mode = held;
  rest.reset.map = [](double, const Vector&, const Vector& p, Vector& out) { out << p[r], 0.0; };
  rest.reset.dx = [](double, const Vector&, const Vector&, Matrix& J) { J.setZero(); };
  rest.reset.dp = [](double, const Vector&, const Vector&, Matrix& J) {
    J.setZero();
    J(0, r) = 1.0;
  };
  event.accumulation = rest;
  return event;
}

Event release() {
  Event event;
  event.name = "release";
  event.from = held;
  event.to = free_flight;
  event.kind = EventKind::release;
  event.guard.value = [](double t, const Vector&, const Vector& p) { return -barrier_acceleration(t, p); };
  event.guard.dx = [](double, const Vector&, const Vector&, Vector& g) { g.setZero(); };
  event.guard.dt = [](double t, const Vector&, const Vector& p) { return p[xi] * p[eta] * std::sin(p[eta] * t); };
  event.guard.dp = [](double t, const Vector&, const Vector& p, Vector& g) {
    g.setZero();
    g[xi] = -std::cos(p[eta] * t);
    g[eta] = p[xi] * t * std::sin(p[eta] * t);
    g[r] = 1.0 + 3.0 * p[beta] * p[r] * p[r];
    g[beta] = p[r] * p[r] * p[r];
  };
  // At release the acceleration of the free mass at (r, 0) is zero: state and field are continuous.
  event.continuous = true;
  return event;
}

void attach_newton(HybridSystem& system) {
  system.modes.push_back(held_mode());
  system.events.push_back(impact());
  system.events.push_back(release());
  system.initial_mode = [](double t, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    // A mass on the barrier up to rounding is not inside.
    if (x[0] - p[r] > guard_tolerance * (1.0 + std::abs(x[0]))) return std::nullopt;
    const bool at_rest_on_barrier = x[0] == p[r] && x[1] == 0.0;
    return at_rest_on_barrier && barrier_acceleration(t, p) > 0.0 ? held : free_flight;
  };
}

}  // namespace

HybridSystem hand_written_oscillator(const OscillatorKind& kind, const ContactLaw& law) {
  HybridSystem system;
  system.name = kind.name + "-" + law.name;
  system.states = 2;
  system.parameters = oscillator_parameters();
  system.parameters[beta].default_value = kind.beta;
  system.parameters.insert(system.parameters.end(), law.parameters.begin(), law.parameters.end());
  system.forcing_frequency = eta;
  system.modes.push_back(free_mode());
  if (law.name == "hertz") attach_hertz(system);
  if (law.name == "linear") attach_linear(system);
  if (law.name == "newton") attach_newton(system);
  validate(system);
  return system;
}

}  // namespace graze::support
