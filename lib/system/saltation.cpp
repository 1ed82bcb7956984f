// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/system/saltation.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

/// Rounding error of a difference of sums of a few products, relative to the size of its terms.
constexpr double jump_rounding = 8.0 * std::numeric_limits<double>::epsilon();

}  // namespace

double transversality(const Guard& guard, double t, const Vector& x, const Vector& f, const Vector& p) {
  if (guard.level) return guard.level->sign * f[static_cast<Eigen::Index>(guard.level->coordinate)];
  Vector gradient(x.size());
  guard.dx(t, x, p, gradient);
  return gradient.dot(f) + (guard.dt ? guard.dt(t, x, p) : 0.0);
}

double transversality_change(const Guard& guard, double t, const Vector& x, const Vector& f, const Vector& p, double dt,
                             const Vector& dx, const Vector& dp) {
  if (guard.level) return 0.0;
  double scale = std::abs(dt);
  if (dx.size() > 0) scale = std::max(scale, dx.lpNorm<Eigen::Infinity>() / (1.0 + x.lpNorm<Eigen::Infinity>()));
  if (dp.size() > 0) scale = std::max(scale, dp.lpNorm<Eigen::Infinity>());
  if (!(scale > 0.0)) return 0.0;
  const double step = 3e-4 / scale;
  const auto at = [&](double s) {
    const Vector there = dx.size() > 0 ? Vector(x + s * dx) : x, with = dp.size() > 0 ? Vector(p + s * dp) : p;
    return transversality(guard, t + s * dt, there, f, with);
  };
  return (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
}

GuardAndRate guard_and_rate(const Guard& guard, const Mode& mode, double t, const Vector& x, const Vector& p,
                            std::size_t parameter) {
  const Eigen::Index n = x.size(), index = static_cast<Eigen::Index>(parameter);
  Vector f(n), f_dt = Vector::Zero(n), h_dp = Vector::Zero(p.size());
  Matrix f_dx(n, n), f_dp = Matrix::Zero(n, p.size());
  mode.field(t, x, p, f);
  mode.field_dx(t, x, p, f_dx);
  mode.field_dp(t, x, p, f_dp);
  if (mode.field_dt) mode.field_dt(t, x, p, f_dt);
  GuardAndRate out;
  out.h_dx.resize(n);
  guard.dx(t, x, p, out.h_dx);
  if (guard.dp) guard.dp(t, x, p, h_dp);
  out.h = guard.value(t, x, p);
  out.rate = out.h_dx.dot(f) + (guard.dt ? guard.dt(t, x, p) : 0.0);
  const auto change = [&](double dt, const Vector& dx, const Vector& dp) {
    return transversality_change(guard, t, x, f, p, dt, dx, dp);
  };
  out.rate_dx = f_dx.transpose() * out.h_dx;
  for (Eigen::Index i = 0; i < n; ++i) out.rate_dx[i] += change(0.0, Vector::Unit(n, i), {});
  out.rate_dt = out.h_dx.dot(f_dt) + change(1.0, {}, {});
  out.h_dp = h_dp[index];
  out.rate_dp = out.h_dx.dot(f_dp.col(index)) + change(0.0, {}, Vector::Unit(p.size(), index));
  return out;
}

SaltationMatrix saltation(const Event& event, const Crossing& crossing, const Vector& p, std::span<const std::size_t> active) {
  SaltationMatrix result;
  saltation(event, crossing, p, active, result);
  return result;
}

void saltation(const Event& event, const Crossing& crossing, const Vector& p, std::span<const std::size_t> active,
               SaltationMatrix& result) {
  const Eigen::Index n = crossing.x_minus.size();
  const auto m = static_cast<Eigen::Index>(active.size());
  result.regular = false;
  result.transversality = transversality(event.guard, crossing.t, crossing.x_minus, crossing.f_minus, p);
  if (event.continuous) {
    result.regular = true;
    result.S.setIdentity(n, n);
    result.Sp.setZero(n, m);
    return;
  }
  const double c = result.transversality;
  if (!(std::abs(c) > grazing_transversality * (1.0 + crossing.f_minus.lpNorm<Eigen::Infinity>()))) {
    result.S.setConstant(n, n, std::numeric_limits<double>::quiet_NaN());
    result.Sp.setConstant(n, m, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  if (event.guard.level && event.reset.rebound && n == 2 && m == 0) {  // the same in closed form
    const Rebound& rebound = *event.reset.rebound;
    const auto position = static_cast<Eigen::Index>(rebound.coordinate), velocity = static_cast<Eigen::Index>(rebound.velocity);
    const double restitution = p[static_cast<Eigen::Index>(rebound.coefficient)];
    const double rate = event.guard.level->sign / c;
    result.regular = true;
    result.S.setZero(n, n);
    result.S(velocity, velocity) = -restitution;
    result.S(position, position) += crossing.f_plus[position] * rate;
    result.S(velocity, position) += (crossing.f_plus[velocity] + restitution * crossing.f_minus[velocity]) * rate;
    result.Sp.setZero(n, 0);
    return;
  }
  Matrix& reset_dx = result.S;
  reset_dx.setIdentity(n, n);
  Vector jump = crossing.f_plus, size = crossing.f_plus.cwiseAbs();
  if (event.reset.map) {
    event.reset.dx(crossing.t, crossing.x_minus, p, reset_dx);
    if (event.reset.dt) {
      Vector reset_dt(n);
      event.reset.dt(crossing.t, crossing.x_minus, p, reset_dt);
      jump -= reset_dt;
      size += reset_dt.cwiseAbs();
    }
  }
  jump.noalias() -= reset_dx * crossing.f_minus;
  // A difference at the level of rounding is set to zero: c may be small, and S is singular where a constraint begins.
  size += reset_dx.cwiseAbs() * crossing.f_minus.cwiseAbs();
  for (Eigen::Index i = 0; i < n; ++i)
    if (std::abs(jump[i]) <= jump_rounding * size[i]) jump[i] = 0.0;
  Vector gradient(n);
  event.guard.dx(crossing.t, crossing.x_minus, p, gradient);
  result.regular = true;
  result.S += jump.lazyProduct(gradient.transpose()) / c;
  result.Sp.setZero(n, m);
  if (m > 0) {
    Matrix reset_dp = Matrix::Zero(n, p.size());
    if (event.reset.map && event.reset.dp) event.reset.dp(crossing.t, crossing.x_minus, p, reset_dp);
    Vector guard_dp = Vector::Zero(p.size());
    if (event.guard.dp) event.guard.dp(crossing.t, crossing.x_minus, p, guard_dp);
    for (Eigen::Index k = 0; k < m; ++k) {
      const auto parameter = static_cast<Eigen::Index>(active[static_cast<std::size_t>(k)]);
      result.Sp.col(k) = reset_dp.col(parameter) + jump * (guard_dp[parameter] / c);
    }
  }
}

}  // namespace graze
