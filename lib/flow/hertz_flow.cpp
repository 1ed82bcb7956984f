// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/flow/hertz_flow.hpp>

#include <graze/lib/flow/hertz_series.hpp>
#include <graze/lib/flow/hertz_step.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

using C = HertzContact;

/// Root by Newton's method, kept in the bracket [0, h]. value(s) returns a quantity of a partial step and its derivative;
/// value(0) < 0 <= value(h).
template <class Value> double root_in_step(const Value& value, double h) {
  double lo = 0.0, hi = h, s = h;
  for (int i = 0; i < 60; ++i) {
    const auto [g, slope] = value(s);
    (g < 0.0 ? lo : hi) = s;
    const double next = s - g / slope;
    const bool inside = next >= lo && next <= hi;
    if (inside && std::abs(next - s) <= 1e-9 * h) return next;  // quadratic convergence: the error left is below rounding
    s = inside ? next : 0.5 * (lo + hi);
  }
  return s;
}

}  // namespace

bool HertzFlow::applies(const HybridSystem& system, std::size_t mode, const HertzContact& contact) {
  int events = 0;
  for (const Event& event : system.events) {
    if (event.from != mode) continue;
    ++events;
    const auto& level = event.guard.level;
    if (!level || level->coordinate != 0 || level->sign > 0.0 || !is_barrier(contact, level->level)) return false;
  }
  return system.states == 2 && events == 1;
}

HertzFlow::HertzFlow(const HybridSystem& system, std::size_t mode, std::span<const std::size_t> active,
                     const HertzContact& contact, const FlowOptions& options)
    : contact_(contact), options_(options), sources_(contact.dp, active) {
  for (std::size_t i = 0; i < system.events.size(); ++i)
    if (system.events[i].from == mode) leave_ = i;
}

void HertzFlow::field(double t, const Vector& x, Vector& out) const {
  const auto& q = contact_.value;
  const double y = std::sqrt(std::max(0.0, x[0] - q[C::barrier]));
  out[0] = x[1];
  out[1] = q[C::amplitude] * std::cos(q[C::frequency] * t) - 2.0 * q[C::damping] * x[1] - x[0] - q[C::beta] * x[0] * x[0] * x[0] -
           q[C::stiffness] * y * y * y * (1.0 + q[C::contact_damping] * x[1]);
}

void HertzFlow::carry(const FlowTask& task, const Vector& x0, Segment& out) const {
  if (task.sensitivity == Sensitivity::none) return carry_with<0>(task, x0, out);
  if (task.sensitivity == Sensitivity::state || sources_.coefficients.empty()) {
    carry_with<1>(task, x0, out);
    out.Psi.setZero(2, task.sensitivity == Sensitivity::state ? 0 : sources_.dp.cols());
    return;
  }
  if (sources_.coefficients.size() <= 4) return carry_with<2>(task, x0, out);
  static_assert(C::count <= 8);
  carry_with<3>(task, x0, out);
}

double HertzFlow::speed_coefficient(double y) const {
  const auto& p = contact_.value;
  return 2.0 * p[C::damping] + p[C::stiffness] * p[C::contact_damping] * y * y * y;
}

template <std::size_t Quads>
void HertzFlow::start_from_rest(const FlowTask& task, double dt, detail::HertzState<Quads>& z) const {
  const auto& p = contact_.value;
  const double r = p[C::barrier], v = z.v, w = p[C::frequency], c = z.cosine, s = z.sine;
  const double a = p[C::amplitude] * c - 2.0 * p[C::damping] * v - r - p[C::beta] * r * r * r;
  const double jerk = -p[C::amplitude] * w * s - 2.0 * p[C::damping] * a;
  const auto root_depth = [&](double t) { return std::sqrt(std::max(0.0, t * (v + t * (a / 2 + jerk * t / 6)))); };
  const double y = root_depth(dt), t = task.t0 + dt, middle = task.t0 + dt / 2;
  z.y = y;
  z.v = v + dt * (a + jerk * dt / 2);
  z.cosine = std::cos(w * t);
  z.sine = std::sin(w * t);
  z.time = dt;
  z.divergence = -2.0 * p[C::damping] * dt;
  if constexpr (Quads > 0) {
    Eigen::Matrix2d A;
    A << 0.0, 1.0, -1.0 - 3.0 * p[C::beta] * r * r, -2.0 * p[C::damping];
    Eigen::Matrix2d Phi = Eigen::Matrix2d::Identity() + A * dt + A * A * (dt * dt / 2);
    // The integral of the contact's own stiffness, 1.5 k_H y.
    const double stiffness = 1.5 * p[C::stiffness] * (4.0 * root_depth(dt / 2) + y) * dt / 6;
    Phi(1, 0) -= stiffness;
    for (Eigen::Index k = 0; k < 2; ++k) {
      z.dx[k] = Phi(0, k);
      z.q[k] = Phi(1, k) + speed_coefficient(y) * Phi(0, k);
    }
    if constexpr (Quads > 1) {
      for (std::size_t k = 0; k < sources_.coefficients.size(); ++k) {
        double f_p = 0.0;  // in the middle; terms that depend on the depth vanish
        switch (sources_.coefficients[k]) {
        case C::damping:
          f_p = -2.0 * (v + a * dt / 2);
          break;
        case C::beta:
          f_p = -r * r * r;
          break;
        case C::amplitude:
          f_p = std::cos(w * middle);
          break;
        case C::frequency:
          f_p = -p[C::amplitude] * middle * std::sin(w * middle);
          break;
        default:
          break;
        }
        const double dx = f_p * dt * dt / 2;
        const double dv = f_p * (dt - p[C::damping] * dt * dt) + (sources_.coefficients[k] == C::barrier ? stiffness : 0.0);
        z.dx[2 + k] = dx;
        z.q[2 + k] = dv + speed_coefficient(y) * dx;
      }
    }
  }
}

template <std::size_t Quads> void HertzFlow::carry_with(const FlowTask& task, const Vector& x0, Segment& out) const {
  using State = detail::HertzState<Quads>;
  const auto& p = contact_.value;
  const double r = p[C::barrier], duration = task.t_end - task.t0;
  const auto set_phase = [&](State& z) {
    const double phase = p[C::frequency] * (task.t0 + z.time);
    z.cosine = std::cos(phase);
    z.sine = std::sin(phase);
  };
  State z;
  z.y = std::sqrt(std::max(0.0, x0[0] - r));
  z.v = x0[1];
  set_phase(z);
  if constexpr (Quads > 0) {
    z.dx[0] = z.q[1] = 1.0;
    z.q[0] = speed_coefficient(z.y);
  }
  out.t0 = task.t0;
  out.x0 = x0;
  out.end = FlowEnd::failed;
  out.evaluations = 0;

  const auto finish = [&](FlowEnd end, const State& last) {
    const double y = last.y;
    out.end = end;
    out.event = leave_;
    out.t1 = end == FlowEnd::time ? task.t_end : task.t0 + last.time;
    out.x1.resize(2);
    out.x1 << (end == FlowEnd::event ? r : r + y * y), last.v;
    if constexpr (Quads > 0) {
      out.divergence = last.divergence;
      const double q_of_dx = speed_coefficient(y);
      const auto dv = [&](Eigen::Index column) { return last.q[column] - q_of_dx * last.dx[column]; };
      out.Phi.resize(2, 2);
      out.Phi << last.dx[0], last.dx[1], dv(0), dv(1);
      if constexpr (Quads > 1) {
        Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, C::count> columns(2, sources_.dp.rows());
        for (Eigen::Index k = 0; k < columns.cols(); ++k) columns.col(k) << last.dx[2 + k], dv(2 + k);
        out.Psi.noalias() = columns * sources_.dp;
      }
    }
  };

  // Longest step, a fraction of the shortest contact in s: half a turn about the equilibrium (0, 0), pi sqrt(2/|a|). Here a is
  // the largest acceleration at the barrier within dt at speeds up to v.
  const auto longest_step = [&](double cosine, double v, double dt) {
    const double a = std::abs(p[C::amplitude] * cosine - r * (1.0 + p[C::beta] * r * r)) + 2.0 * p[C::damping] * std::abs(v) +
                     std::abs(p[C::amplitude]) * p[C::frequency] * dt;
    return detail::hertz_longest_step * std::sqrt(2.0 / std::max(a, 1e-12));
  };

  if (z.y == 0.0 && z.v <= rest_tolerance) {
    const double a = p[C::amplitude] * z.cosine - 2.0 * p[C::damping] * z.v - r * (1.0 + p[C::beta] * r * r);
    if (z.v < -rest_tolerance * (1.0 + std::abs(a))) return finish(FlowEnd::event, z);
    // From rest on the barrier the motion is analytic in t, not in s: a series in t covers a first short interval (truncated at
    // t^4).
    start_from_rest(task, std::min(1e-5, duration), z);
    if (z.y == 0.0 && z.v <= 0.0) return finish(FlowEnd::event, z);
  }

  constexpr std::size_t order = detail::hertz_order;
  const double ratio = std::pow(options_.tolerance, 1.0 / order), allowed = detail::hertz_last_term * options_.tolerance;
  detail::HertzSeries<Quads> series(contact_, sources_.coefficients, task.t0);
  double h = longest_step(z.cosine, z.v, 0.0);
  for (std::size_t step = 1; step <= options_.max_steps; ++step) {
    if (z.time >= duration) return finish(FlowEnd::time, z);
    series.expand(z);
    out.evaluations += order;
    // From two coefficients, as one may be small by chance.
    const double size = std::max(series.last(), series.before() * ratio / h);
    if (!std::isfinite(size)) break;
    const double v = std::abs(z.v), longest = longest_step(z.cosine, v, 0.0);
    h = std::min(longest, detail::rough_root(allowed, size));
    State next = series.at(h);
    const double checked = longest_step(z.cosine, std::max(v, std::abs(next.v)), std::abs(next.time - z.time));
    if (h > checked) {
      h = checked;
      next = series.at(h);
    }
    if (!std::isfinite(next.y + next.v + next.time)) break;
    const bool surfaced = !(next.y > 0.0), late = next.time >= duration;
    if (surfaced || late) {
      double s = h;
      FlowEnd end = FlowEnd::time;
      if (surfaced) {
        s = root_in_step([&](double trial) { return std::pair{-series.depth(trial), -0.5 * series.speed(trial)}; }, h);
        if (series.time(s) <= duration) end = FlowEnd::event;
      }
      if (end == FlowEnd::time) {
        s = root_in_step([&](double trial) { return std::pair{series.time(trial) - duration, series.depth(trial)}; }, s);
      }
      return finish(end, series.at(s));
    }
    z = next;
    if (step % 16 == 0) set_phase(z);  // the phase must not drift from the time
  }
  finish(FlowEnd::failed, z);
}

}  // namespace graze
