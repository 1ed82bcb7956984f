// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/hertz_flow.hpp>

#include <graze/lib/detail/runge_kutta8.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace graze {

namespace {

using C = HertzContact;

/// cos and sin of w t near a reference instant, by Taylor series where the angle is small (every stage of a step is near its
/// start).
class NearbyCosine {
 public:
  NearbyCosine(double frequency, double t)
      : frequency_(frequency), t_(t), c_(std::cos(frequency * t)), s_(std::sin(frequency * t)) {}
  void operator()(double t, double& c, double& s) const {
    const double d = frequency_ * (t - t_), z = d * d;
    double cd, sd;
    if (z < 0.0625) {
      cd = 1.0 - z / 2 * (1.0 - z / 12 * (1.0 - z / 30 * (1.0 - z / 56 * (1.0 - z / 90 * (1.0 - z / 132)))));
      sd = d * (1.0 - z / 6 * (1.0 - z / 20 * (1.0 - z / 42 * (1.0 - z / 72 * (1.0 - z / 110)))));
    } else {
      cd = std::cos(d);
      sd = std::sin(d);
    }
    c = c_ * cd - s_ * sd;
    s = s_ * cd + c_ * sd;
  }

 private:
  double frequency_, t_, c_, s_;
};

/// Layout of the integrated vector: y, v, t, divergence, then the columns of (Phi | Psi), two entries each.
constexpr std::size_t base = 4;

template <std::size_t Columns> struct Equations {
  const C& contact;
  const std::vector<std::size_t>& coefficient_of_active;
  NearbyCosine cosine;
  static constexpr std::size_t size = base + 2 * Columns;

  void operator()(const detail::Stage<size>& z, detail::Stage<size>& dz) const {
    const auto& q = contact.value;
    const double y = z[0], v = z[1], x = q[C::barrier] + y * y, y3 = y * y * y;
    double c, s;
    cosine(z[2], c, s);
    const double give = 1.0 + q[C::contact_damping] * v;
    dz[0] = 0.5 * v;
    dz[1] = y * (q[C::amplitude] * c - 2.0 * q[C::damping] * v - x * (1.0 + q[C::beta] * x * x) - q[C::stiffness] * y3 * give);
    dz[2] = y;
    if constexpr (Columns == 0) {
      dz[3] = 0.0;
    } else {
      const double f_x = -1.0 - 3.0 * q[C::beta] * x * x - 1.5 * q[C::stiffness] * y * give;
      const double f_v = -2.0 * q[C::damping] - q[C::stiffness] * y3 * q[C::contact_damping];
      dz[3] = y * f_v;
      for (std::size_t k = 0; k < Columns; ++k) {
        const double dx = z[base + 2 * k], dv = z[base + 2 * k + 1];
        dz[base + 2 * k] = y * dv;
        dz[base + 2 * k + 1] = y * (f_x * dx + f_v * dv);
      }
      if constexpr (Columns > 2) {
        for (std::size_t k = 2; k < Columns && k - 2 < coefficient_of_active.size(); ++k)
          dz[base + 2 * k + 1] += y * derivative(coefficient_of_active[k - 2], x, v, y, z[2], c, s);
      }
    }
  }

  /// Derivative of the acceleration in a coefficient, at fixed (t, x, v).
  double derivative(std::size_t coefficient, double x, double v, double y, double t, double c, double s) const {
    const auto& q = contact.value;
    const double give = 1.0 + q[C::contact_damping] * v;
    switch (coefficient) {
    case C::damping:
      return -2.0 * v;
    case C::beta:
      return -x * x * x;
    case C::amplitude:
      return c;
    case C::frequency:
      return -q[C::amplitude] * t * s;
    case C::barrier:
      return 1.5 * q[C::stiffness] * y * give;
    case C::stiffness:
      return -y * y * y * give;
    case C::contact_damping:
      return -q[C::stiffness] * y * y * y * v;
    default:
      return 0.0;
    }
  }
};

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
  if (task.sensitivity == Sensitivity::none) return carry_with<0>(task, x0, false, out);
  const std::size_t parameters = task.sensitivity == Sensitivity::state ? 0 : coefficient_of_active_.size();
  if (parameters == 0) return carry_with<2>(task, x0, true, out);
  if (parameters == 1) return carry_with<3>(task, x0, true, out);
  carry_with<2 + C::count>(task, x0, true, out);
}

template <std::size_t Columns>
void HertzFlow::carry_with(const FlowTask& task, const Vector& x0, bool tangent, Segment& out) const {
  constexpr std::size_t size = Equations<Columns>::size;
  using Z = detail::Stage<size>;
  const auto& q = contact_.value;
  const double r = q[C::barrier];
  Z z{};
  z[0] = std::sqrt(std::max(0.0, x0[0] - r));
  z[1] = x0[1];
  z[2] = task.t0;
  if constexpr (Columns >= 2) z[base] = z[base + 3] = 1.0;
  out.t0 = task.t0;
  out.x0 = x0;
  out.end = FlowEnd::failed;
  out.evaluations = 0;

  const auto finish = [&](FlowEnd end, double t1, const Z& last) {
    out.end = end;
    out.event = leave_;
    out.t1 = t1;
    out.x1.resize(2);
    out.x1 << (end == FlowEnd::event ? r : r + last[0] * last[0]), last[1];
    if (!tangent) return;
    out.divergence = last[3];
    if constexpr (Columns >= 2) {
      out.Phi = Eigen::Map<const Eigen::Matrix2d>(last.data() + base);
      if constexpr (Columns > 2) {
        out.Psi = Eigen::Map<const Matrix>(last.data() + base + 4, 2, static_cast<Eigen::Index>(coefficient_of_active_.size()));
      } else {
        out.Psi.resize(2, 0);
      }
    }
  };

  // Shortest contact in s: half a turn about the equilibrium (0, 0), pi sqrt(2/|a|), a being the acceleration at the barrier:
  // of all accelerations met there within dt after t at speeds up to v.
  const auto longest_step = [&](double t, double v, double dt) {
    const double a = std::abs(q[C::amplitude] * std::cos(q[C::frequency] * t) - r * (1.0 + q[C::beta] * r * r)) +
                     2.0 * q[C::damping] * std::abs(v) + std::abs(q[C::amplitude]) * q[C::frequency] * dt;
    return 0.3 * std::numbers::pi * std::sqrt(2.0 / std::max(a, 1e-12));
  };

  if (z[0] == 0.0 && z[1] <= rest_tolerance) {
    const double c = std::cos(q[C::frequency] * task.t0), s = std::sin(q[C::frequency] * task.t0), v = z[1];
    const double a = q[C::amplitude] * c - 2.0 * q[C::damping] * v - r - q[C::beta] * r * r * r;
    if (v < -rest_tolerance * (1.0 + std::abs(a))) return finish(FlowEnd::event, task.t0, z);
    // From rest on the barrier the motion is analytic in t, not in s: its series over a first short while (terms left out: t^4).
    const double dt = std::min(1e-5, task.t_end - task.t0);
    const double jerk = -q[C::amplitude] * q[C::frequency] * s - 2.0 * q[C::damping] * a;
    const auto root_depth = [&](double t) { return std::sqrt(std::max(0.0, t * (v + t * (a / 2 + jerk * t / 6)))); };
    z[0] = root_depth(dt);
    z[1] = v + dt * (a + jerk * dt / 2);
    z[2] += dt;
    z[3] = -2.0 * q[C::damping] * dt;
    if constexpr (Columns >= 2) {
      const Equations<Columns> at_start{contact_, coefficient_of_active_, NearbyCosine(q[C::frequency], task.t0)};
      Eigen::Matrix2d A;
      A << 0.0, 1.0, -1.0 - 3.0 * q[C::beta] * r * r, -2.0 * q[C::damping];
      Eigen::Map<Eigen::Matrix2d>(z.data() + base) += A * dt + A * A * (dt * dt / 2);
      // What the contact's own stiffness, 1.5 k_H y, adds up to.
      const double stiffness = 1.5 * q[C::stiffness] * (4.0 * root_depth(dt / 2) + z[0]) * dt / 6;
      z[base + 1] -= stiffness;
      double middle_c, middle_s;
      at_start.cosine(task.t0 + dt / 2, middle_c, middle_s);
      for (std::size_t k = 2; k < Columns && k - 2 < coefficient_of_active_.size(); ++k) {
        const std::size_t coefficient = coefficient_of_active_[k - 2];
        const Eigen::Vector2d f_p(0.0, at_start.derivative(coefficient, r, v + a * dt / 2, 0.0, task.t0 + dt / 2, middle_c, middle_s));
        Eigen::Map<Eigen::Vector2d>(z.data() + base + 2 * k) = f_p * dt + A * f_p * (dt * dt / 2);
        if (coefficient == C::barrier) z[base + 2 * k + 1] += stiffness;
      }
    }
    if (z[0] == 0.0 && z[1] <= 0.0) return finish(FlowEnd::event, z[2], z);
  }

  double h = 0.25 * longest_step(z[2], z[1], 0.0);
  Z k1, next, error;
  for (std::size_t step = 0; step < options_.max_steps; ++step) {
    if (z[2] >= task.t_end) return finish(FlowEnd::time, task.t_end, z);
    const Equations<Columns> equations{contact_, coefficient_of_active_, NearbyCosine(q[C::frequency], z[2])};
    equations(z, k1);
    detail::rk8_step<size>(equations, z, k1, h, next, error);
    out.evaluations += 13;
    double worst = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < size; ++i) {
      const double relative = std::abs(error[i]) / (1.0 + std::abs(next[i]));
      worst = std::max(worst, relative);
      sum += relative;
    }
    if (!std::isfinite(sum)) worst = std::numeric_limits<double>::infinity();  // far beyond y = 0 the equations blow up
    const double factor = 0.9 * std::pow(options_.tolerance / std::max(worst, 1e-30), 1.0 / 8.0);
    if (worst > options_.tolerance && h > 1e-10) {
      h *= std::clamp(factor, 0.1, 0.9);
      continue;
    }
    if (!std::isfinite(worst)) break;
    const double longest = longest_step(z[2], std::max(std::abs(z[1]), std::abs(next[1])), std::abs(next[2] - z[2]));
    if (h > longest) {
      h = longest;
      continue;
    }
    const bool surfaced = next[0] <= 0.0, late = next[2] >= task.t_end;
    if (surfaced || late) {
      // Roots are found on the state alone, by partial steps from the start of this one; then the tangent follows once.
      const Equations<0> state{contact_, coefficient_of_active_, equations.cosine};
      const detail::Stage<base> from{z[0], z[1], z[2], 0.0}, slope{k1[0], k1[1], k1[2], 0.0};
      detail::Stage<base> here, ignored;
      const auto partial = [&](double s) {
        detail::rk8_step<base>(state, from, slope, s, here, ignored);
        out.evaluations += 12;
      };
      double s = h;
      FlowEnd end = FlowEnd::time;
      if (surfaced) {
        s = root_in_step(
            [&](double trial) {
              partial(trial);
              return std::pair{-here[0], -0.5 * here[1]};
            },
            h);
        partial(s);
        if (here[2] <= task.t_end) end = FlowEnd::event;
      }
      if (end == FlowEnd::time) {
        s = root_in_step(
            [&](double trial) {
              partial(trial);
              return std::pair{here[2] - task.t_end, here[0]};
            },
            s);
      }
      detail::rk8_step<size>(equations, z, k1, s, next, error);
      out.evaluations += 12;
      return finish(end, end == FlowEnd::event ? next[2] : task.t_end, next);
    }
    z = next;
    h = std::min(longest, h * std::clamp(factor, 0.5, 4.0));
  }
  finish(FlowEnd::failed, z[2], z);
}

}  // namespace graze
