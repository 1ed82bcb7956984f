// SPDX-License-Identifier: GPL-3.0-or-later
// Newton's law of restitution at a rigid stop: x <= r always; at x = r moving in, x'+ = -k_r x'-.
// With k_r < 1 impacts may accumulate; the mass is then held at (r, 0) while xi cos(eta tau) - r - beta r^3 > 0 presses it
// there, and released when that changes sign. |det S| = k_r^2 at an impact.
#include <graze/lib/models/laws.hpp>
#include <graze/lib/models/oscillator.hpp>

#include <cmath>

namespace graze {

namespace {

using namespace oscillator_parameter;
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
  // At release the acceleration of the free mass at (r, 0) is zero: state and field go over continuously.
  event.continuous = true;
  return event;
}

void attach(HybridSystem& system) {
  system.modes.push_back(held_mode());
  system.events.push_back(impact());
  system.events.push_back(release());
  system.initial_mode = [](double t, const Vector& x, const Vector& p) -> std::optional<std::size_t> {
    if (x[0] - p[r] > guard_tolerance * (1.0 + std::abs(x[0]))) return std::nullopt;  // on it, but for rounding, is not inside
    const bool at_rest_on_barrier = x[0] == p[r] && x[1] == 0.0;
    return at_rest_on_barrier && barrier_acceleration(t, p) > 0.0 ? held : free_flight;
  };
}

}  // namespace

ContactLaw newton_law() {
  ContactLaw law;
  law.name = "newton";
  law.formula = "x'+ = -k_r x'- at x = r; x <= r always";
  law.hard = true;
  law.parameters = {{"k_r", 1.0, 0.0, 1.0, false, "dimensionless", "coefficient of restitution"}};
  law.attach = attach;
  return law;
}

}  // namespace graze
