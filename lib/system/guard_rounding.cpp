// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/system/guard_rounding.hpp>

#include <cmath>

namespace graze {

GuardScale guard_scale(const Guard& guard, double t, const Vector& x, const Vector& p) {
  GuardScale scale;
  if (guard.level) return scale;
  Vector gradient(x.size());
  guard.dx(t, x, p, gradient);
  if (gradient.allFinite()) scale.dx = gradient.lpNorm<Eigen::Infinity>();
  if (guard.dt)
    if (const double dt = guard.dt(t, x, p); std::isfinite(dt)) scale.dt = std::abs(dt);
  return scale;
}

double guard_width(const GuardScale& scale, double t, const Vector& x) {
  return guard_tolerance * (scale.dx * (1.0 + x.lpNorm<Eigen::Infinity>()) + scale.dt * (1.0 + std::abs(t)));
}

bool rests(double rate, const GuardScale& scale, const Vector& f) {
  return std::abs(rate) <= rest_tolerance * (scale.dx * (1.0 + f.lpNorm<Eigen::Infinity>()) + scale.dt);
}

}  // namespace graze
