// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/hertz_flow.hpp>

#include <graze/lib/detail/hertz_series.hpp>
#include <graze/lib/detail/hertz_step.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

using C = HertzContact;

/// Newton, kept in the bracket, on a quantity of a partial step: value(s) returns it with its derivative; value(0) < 0 <=
/// value(h).
template <class Value> double root_in_step(const Value& value, double h) {
  double lo = 0.0, hi = h, s = h;
  for (int i = 0; i < 60; ++i) {
    const auto [g, slope] = value(s);
    (g < 0.0 ? lo : hi) = s;
    const double next = s - g / slope;
    const bool inside = next >= lo && next <= hi;
    if (inside && std::abs(next - s) <= 1e-9 * h) return next;  // it converges quadratically: what is left is below rounding
    s = inside ? next : 0.5 * (lo + hi);
  }
  return s;
}

}  // namespace

bool HertzFlow::applies(const HybridSystem& system, std::size_t mode, std::span<const std::size_t> active,
                        const HertzContact& contact) {
  if (active.size() > C::count) return false;
  int events = 0;
  for (const Event& event : system.events) {
    if (event.from != mode) continue;
    ++events;
    const auto& level = event.guard.level;
    if (!level || level->coordinate != 0 || level->sign > 0.0 || level->level != contact.parameter[C::barrier]) return false;
  }
  return system.states == 2 && events == 1;
}

HertzFlow::HertzFlow(const HybridSystem& system, std::size_t mode, std::span<const std::size_t> active,
                     const HertzContact& contact, const FlowOptions& options)
    : contact_(contact), options_(options) {
  for (std::size_t i = 0; i < system.events.size(); ++i)
    if (system.events[i].from == mode) leave_ = i;
  for (const std::size_t parameter : active) {
    const auto found = std::find(contact.parameter.begin(), contact.parameter.end(), parameter);
    coefficient_of_active_.push_back(static_cast<std::size_t>(found - contact.parameter.begin()));
  }
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
  const std::size_t parameters = task.sensitivity == Sensitivity::state ? 0 : coefficient_of_active_.size();
  if (parameters == 0) return carry_with<1>(task, x0, out);
  if (parameters <= 2) return carry_with<2>(task, x0, out);
  carry_with<1 + (C::count + 1) / 2>(task, x0, out);
}

double HertzFlow::speed_coefficient(double y) const {
  const auto& p = contact_.value;
  return 2.0 * p[C::damping] + p[C::stiffness] * p[C::contact_damping] * y * y * y;
}

template <std::size_t Pairs> void HertzFlow::leave_rest(const FlowTask& task, double dt, detail::HertzState<Pairs>& z) const {
  const auto& p = contact_.value;
  const double r = p[C::barrier], v = z.yv[1], w = p[C::frequency], c = z.phase[0], s = z.phase[1];
  const double a = p[C::amplitude] * c - 2.0 * p[C::damping] * v - r - p[C::beta] * r * r * r;
  const double jerk = -p[C::amplitude] * w * s - 2.0 * p[C::damping] * a;
  const auto root_depth = [&](double t) { return std::sqrt(std::max(0.0, t * (v + t * (a / 2 + jerk * t / 6)))); };
  const double y = root_depth(dt), t = task.t0 + dt, middle = task.t0 + dt / 2;
  z.yv = detail::Pair{y, v + dt * (a + jerk * dt / 2)};
  z.phase = detail::Pair{std::cos(w * t), std::sin(w * t)};
  z.time = detail::Pair{dt, -2.0 * p[C::damping] * dt};
  if constexpr (Pairs > 0) {
    Eigen::Matrix2d A;
    A << 0.0, 1.0, -1.0 - 3.0 * p[C::beta] * r * r, -2.0 * p[C::damping];
    Eigen::Matrix2d Phi = Eigen::Matrix2d::Identity() + A * dt + A * A * (dt * dt / 2);
    // What the contact's own stiffness, 1.5 k_H y, adds up to.
    const double stiffness = 1.5 * p[C::stiffness] * (4.0 * root_depth(dt / 2) + y) * dt / 6;
    Phi(1, 0) -= stiffness;
    z.dx[0] = detail::Pair{Phi(0, 0), Phi(0, 1)};
    z.q[0] = detail::Pair{Phi(1, 0), Phi(1, 1)} + speed_coefficient(y) * z.dx[0];
    if constexpr (Pairs > 1) {
      for (std::size_t k = 0; k < coefficient_of_active_.size(); ++k) {
        double f_p = 0.0;  // in the middle; of what depends on the depth nothing is left
        switch (coefficient_of_active_[k]) {
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
        const double dv = f_p * (dt - p[C::damping] * dt * dt) + (coefficient_of_active_[k] == C::barrier ? stiffness : 0.0);
        z.dx[1 + k / 2][k % 2] = dx;
        z.q[1 + k / 2][k % 2] = dv + speed_coefficient(y) * dx;
      }
    }
  }
}

template <std::size_t Pairs> void HertzFlow::carry_with(const FlowTask& task, const Vector& x0, Segment& out) const {
  using State = detail::HertzState<Pairs>;
  const auto& p = contact_.value;
  const double r = p[C::barrier], duration = task.t_end - task.t0;
  const auto set_phase = [&](State& z) {
    const double phase = p[C::frequency] * (task.t0 + z.time[0]);
    z.phase = detail::Pair{std::cos(phase), std::sin(phase)};
  };
  State z;
  z.yv = detail::Pair{std::sqrt(std::max(0.0, x0[0] - r)), x0[1]};
  set_phase(z);
  if constexpr (Pairs > 0) {
    z.dx[0] = detail::Pair{1.0, 0.0};
    z.q[0] = detail::Pair{speed_coefficient(z.yv[0]), 1.0};
  }
  out.t0 = task.t0;
  out.x0 = x0;
  out.end = FlowEnd::failed;
  out.evaluations = 0;

  const auto finish = [&](FlowEnd end, const State& last) {
    const double y = last.yv[0];
    out.end = end;
    out.event = leave_;
    out.t1 = end == FlowEnd::time ? task.t_end : task.t0 + last.time[0];
    out.x1.resize(2);
    out.x1 << (end == FlowEnd::event ? r : r + y * y), last.yv[1];
    if constexpr (Pairs > 0) {
      out.divergence = last.time[1];
      const double q_of_dx = speed_coefficient(y);
      const detail::Pair dx = last.dx[0], dv = last.q[0] - q_of_dx * dx;
      out.Phi.resize(2, 2);
      out.Phi << dx[0], dx[1], dv[0], dv[1];
      out.Psi.resize(2, Pairs == 1 ? 0 : static_cast<Eigen::Index>(coefficient_of_active_.size()));
      for (Eigen::Index k = 0; k < out.Psi.cols(); ++k) {
        const std::size_t j = 1 + static_cast<std::size_t>(k) / 2;
        out.Psi.col(k) << last.dx[j][k % 2], last.q[j][k % 2] - q_of_dx * last.dx[j][k % 2];
      }
    }
  };

  // Shortest contact in s: half a turn about the equilibrium (0, 0), pi sqrt(2/|a|), a being the acceleration at the barrier:
  // of all accelerations met there within dt at speeds up to v.
  const auto longest_step = [&](double cosine, double v, double dt) {
    const double a = std::abs(p[C::amplitude] * cosine - r * (1.0 + p[C::beta] * r * r)) + 2.0 * p[C::damping] * std::abs(v) +
                     std::abs(p[C::amplitude]) * p[C::frequency] * dt;
    return detail::hertz_longest_step * std::sqrt(2.0 / std::max(a, 1e-12));
  };

  if (z.yv[0] == 0.0 && z.yv[1] <= rest_tolerance) {
    const double a = p[C::amplitude] * z.phase[0] - 2.0 * p[C::damping] * z.yv[1] - r * (1.0 + p[C::beta] * r * r);
    if (z.yv[1] < -rest_tolerance * (1.0 + std::abs(a))) return finish(FlowEnd::event, z);
    // From rest on the barrier the motion is analytic in t, not in s: its series over a first short while (terms left out: t^4).
    leave_rest(task, std::min(1e-5, duration), z);
    if (z.yv[0] == 0.0 && z.yv[1] <= 0.0) return finish(FlowEnd::event, z);
  }

  constexpr std::size_t order = detail::hertz_order;
  const double ratio = std::pow(options_.tolerance, 1.0 / order), allowed = detail::hertz_last_term * options_.tolerance;
  detail::HertzSeries<order, Pairs> series(contact_, coefficient_of_active_, task.t0);
  double h = longest_step(z.phase[0], z.yv[1], 0.0);
  for (std::size_t step = 1; step <= options_.max_steps; ++step) {
    if (z.time[0] >= duration) return finish(FlowEnd::time, z);
    series.expand(z);
    out.evaluations += order;
    // Of two coefficients, lest one be small by chance.
    const double size = std::max(series.size(order), series.size(order - 1) * ratio / h);
    if (!std::isfinite(size)) break;
    const double v = std::abs(z.yv[1]), longest = longest_step(z.phase[0], v, 0.0);
    h = std::min(longest, detail::rough_root(allowed / size));
    State next = series.at(h);
    const double checked = longest_step(z.phase[0], std::max(v, std::abs(next.yv[1])), std::abs(next.time[0] - z.time[0]));
    if (h > checked) {
      h = checked;
      next = series.at(h);
    }
    if (!std::isfinite(next.yv[0] + next.yv[1] + next.time[0])) break;
    const bool surfaced = !(next.yv[0] > 0.0), late = next.time[0] >= duration;
    if (surfaced || late) {
      double s = h;
      FlowEnd end = FlowEnd::time;
      if (surfaced) {
        s = root_in_step(
            [&](double trial) {
              const detail::Pair yv = series.depth_and_speed(trial);
              return std::pair{-yv[0], -0.5 * yv[1]};
            },
            h);
        if (series.time(s) <= duration) end = FlowEnd::event;
      }
      if (end == FlowEnd::time) {
        s = root_in_step(
            [&](double trial) {
              return std::pair{series.time(trial) - duration, series.depth_and_speed(trial)[0]};
            },
            s);
      }
      return finish(end, series.at(s));
    }
    z = next;
    if (step % 16 == 0) set_phase(z);  // lest it drift from the time
  }
  finish(FlowEnd::failed, z);
}

}  // namespace graze
