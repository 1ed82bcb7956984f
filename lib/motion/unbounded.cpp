// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/unbounded.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace graze {

namespace {

/// Outward force on a mass at rest at the distance X > 0 from the origin, divided by X (so that X^3 does not overflow), with
/// lower bounds of its first and second derivatives.
struct OutwardForce {
  double over_distance = 0.0, slope = 0.0, curvature = 0.0;

  bool grows_from_here() const { return over_distance > 0.0 && slope > 0.0 && curvature > 0.0; }
};

OutwardForce softening_force(double cubic, double stiffness, double amplitude, double outward, double X) {
  return {-cubic * X * X - stiffness + (outward - std::abs(amplitude)) / X, -3.0 * cubic * X * X - stiffness, -6.0 * cubic * X};
}

OutwardForce outward_force(const ModeStructure& structure, double x) {
  const double X = std::abs(x);
  if (const auto* spring = std::get_if<CubicOscillator>(&structure)) {
    using C = CubicOscillator;
    const auto& q = spring->value;
    return softening_force(q[C::cubic], q[C::stiffness], q[C::amplitude], std::copysign(1.0, x) * q[C::constant], X);
  }
  if (const auto* contact = std::get_if<HertzContact>(&structure)) {
    using C = HertzContact;
    const auto& q = contact->value;
    const double depth = x - q[C::barrier], root = std::sqrt(depth);
    if (!(depth > 0.0) || !(x > 0.0)) return {};
    OutwardForce force = softening_force(q[C::beta], 1.0, q[C::amplitude], 0.0, X);
    force.over_distance -= q[C::stiffness] * root * (depth / X);
    force.slope -= 1.5 * q[C::stiffness] * root;
    force.curvature -= 0.75 * q[C::stiffness] / root;
    return force;
  }
  return {};
}

/// Whether an event of the mode may end the motion outward from x.
bool meets_a_guard(const HybridSystem& system, std::size_t mode, double x) {
  return std::any_of(system.events.begin(), system.events.end(), [&](const Event& event) {
    const auto& level = event.guard.level;
    return event.from == mode && (!level || level->coordinate != 0 || level->sign * x > 0.0);
  });
}

}  // namespace

bool escapes(const HybridSystem& system, const Vector& p, std::size_t mode, const Vector& x) {
  if (x.size() != 2 || !system.modes[mode].structure || !(x[0] * x[1] > 0.0) || meets_a_guard(system, mode, x[0])) return false;
  return outward_force(system.modes[mode].structure(p), x[0]).grows_from_here();
}

double resonant_periods(const HybridSystem& system, const Vector& p, const Vector& x) {
  const std::optional<std::size_t> mode = mode_at(system, 0.0, x, p);
  if (!mode || !system.modes[*mode].structure) return 0.0;
  const ModeStructure structure = system.modes[*mode].structure(p);
  const auto* flight = std::get_if<LinearOscillator>(&structure);
  if (!flight || flight->damping != 0.0 || flight->amplitude == 0.0) return 0.0;
  const double w = flight->frequency, rest = flight->constant / flight->stiffness;
  constexpr double rounding = 4.0 * std::numeric_limits<double>::epsilon();  // rounding of a square and of a difference
  if (std::abs(w * w - flight->stiffness) > rounding * flight->stiffness) return 0.0;
  double room = std::numeric_limits<double>::infinity();
  for (const Event& event : system.events) {
    if (event.from != *mode) continue;
    const auto& level = event.guard.level;
    if (!level || level->coordinate != 0) return 0.0;
    room = std::min(room, level->sign * (p[static_cast<Eigen::Index>(level->level)] - rest));
  }
  const double amplitude = std::hypot(x[0] - rest, x[1] / w), each = std::numbers::pi * std::abs(flight->amplitude) / (w * w);
  return std::max(0.0, std::floor((room - amplitude) / each));
}

}  // namespace graze
