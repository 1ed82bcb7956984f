// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/flow/linear_flow.hpp>

#include <graze/lib/flow/bernstein.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

using Matrix2 = Eigen::Matrix2d;
using Vector2 = Eigen::Vector2d;

}  // namespace

/// exp(-b s) times C = cos(sqrt(q2) s) and S = sin(sqrt(q2) s)/sqrt(q2), continued to q2 <= 0; k = q2 + b^2 > 0. Each is formed
/// as one product: for an overdamped oscillator, cosh overflows where exp(-b s) vanishes.
struct LinearFlow::Damped {
  double C, S, decay;
};

LinearFlow::Damped LinearFlow::damped(double s) const {
  const double b = coefficient_.damping, z = q2_ * s * s;
  const double decay = std::exp(-b * s);
  if (std::abs(z) < 1e-4) {  // series: the next terms are below 1e-18
    return {decay * (1.0 - z / 2 * (1.0 - z / 12 * (1.0 - z / 30))), decay * s * (1.0 - z / 6 * (1.0 - z / 20 * (1.0 - z / 42))),
            decay};
  }
  const double q = std::sqrt(std::abs(q2_));
  if (q2_ > 0.0) return {decay * std::cos(q * s), decay * std::sin(q * s) / q, decay};
  const double slow = std::exp(-coefficient_.stiffness / (b + q) * s), lost = -std::expm1(-2.0 * q * s);  // k/(b + q) = b - q
  return {slow * (1.0 - 0.5 * lost), slow * lost / (2.0 * q), decay};
}

/// exp(-b s) dS/d(q2) = (s C - S) / (2 q2), by series where that cancels.
double LinearFlow::dS_dq2(double s, const Damped& f) const {
  const double z = q2_ * s * s;
  if (std::abs(z) > 0.1) return (s * f.C - f.S) / (2.0 * q2_);
  double term = -s * s * s / 6.0, sum = 0.0;  // d/dq2 of sum_k (-q2)^k s^(2k+1)/(2k+1)!
  for (int k = 1; k < 12; ++k) {
    sum += term * k;
    term *= -z / ((2.0 * k + 2.0) * (2.0 * k + 3.0));
  }
  return f.decay * sum;
}

/// Displacement since the start, and five derivatives of x; cosine and sine of the forcing's phase.
struct LinearFlow::Point {
  double dx, v, a, j, x4, x5, c, s;
};

struct LinearFlow::Flight {
  double t0, x0;
  double c, s;  // cosine and sine of the forcing's phase at t0
  double d, e;  // deviation from the particular solution at t0: position and speed
  double near;  // time after the start up to which `series` holds
  // x - x0 = sum of series[i] s^i, because a short flight off a barrier would be lost in the rounding of x.
  std::array<double, 9> series;
};

bool LinearFlow::applies(const HybridSystem& system, std::size_t mode, std::span<const std::size_t> active,
                         const LinearOscillator& oscillator) {
  if (system.states != 2 || !(oscillator.stiffness > 0.0) || oscillator.damping < 0.0) return false;
  if (!detail::guards_are_levels(system, mode)) return false;
  const double detuning = oscillator.stiffness - oscillator.frequency * oscillator.frequency;
  const double drag = 2.0 * oscillator.damping * oscillator.frequency;
  // Near undamped resonance x_p grows without bound and cancels against the transient.
  if (oscillator.amplitude != 0.0 && detuning * detuning + drag * drag < 1e-6 * oscillator.stiffness * oscillator.stiffness)
    return false;
  return std::none_of(active.begin(), active.end(), [&](std::size_t k) {
    const auto& list = oscillator.not_differentiable_in;
    return std::find(list.begin(), list.end(), k) != list.end();
  });
}

LinearFlow::LinearFlow(const HybridSystem& system, std::size_t mode, const Vector& p, std::span<const std::size_t> active,
                       const LinearOscillator& oscillator, std::size_t max_steps)
    : coefficient_(oscillator), max_steps_(max_steps) {
  const double b = oscillator.damping, k = oscillator.stiffness, A = oscillator.amplitude, w = oscillator.frequency;
  q2_ = k - b * b;
  const double detuning = k - w * w, drag = 2.0 * b * w;
  const double D = detuning * detuning + drag * drag;
  const double inverse = D > 0.0 ? 1.0 / D : 0.0;  // D = 0 only without forcing, see applies()
  const double c_unit = detuning * inverse, s_unit = drag * inverse;
  cosine_ = A * c_unit;
  sine_ = A * s_unit;
  forced_ = std::hypot(cosine_, sine_);
  offset_ = oscillator.constant / k;
  // d(detuning, drag)/d(b, k, w) = (0, 2w), (1, 0), (-2w, 2b); D' = 2 (detuning detuning' + drag drag').
  const auto add = [&](int column, double detuning_d, double drag_d) {
    const double D_d = 2.0 * (detuning * detuning_d + drag * drag_d) * inverse;
    particular_dq_(0, column) = A * inverse * detuning_d - cosine_ * D_d;
    particular_dq_(1, column) = A * inverse * drag_d - sine_ * D_d;
  };
  particular_dq_.setZero();
  add(0, 0.0, 2.0 * w);
  add(1, 1.0, 0.0);
  particular_dq_(2, 1) = -offset_ / k;
  particular_dq_(0, 2) = c_unit;
  particular_dq_(1, 2) = s_unit;
  add(3, -2.0 * w, 2.0 * b);
  particular_dq_(2, 4) = 1.0 / k;
  active_dp_ = Matrix::Zero(5, static_cast<Eigen::Index>(active.size()));
  for (std::size_t i = 0; i < active.size(); ++i)
    active_dp_.col(static_cast<Eigen::Index>(i)) = oscillator.dp.col(static_cast<Eigen::Index>(active[i]));
  barriers_ = detail::level_barriers(system, mode, p);
}

void LinearFlow::field(double t, const Vector& x, Vector& out) const {
  const LinearOscillator& q = coefficient_;
  out[0] = x[1];
  out[1] = q.amplitude * std::cos(q.frequency * t) + q.constant - 2.0 * q.damping * x[1] - q.stiffness * x[0];
}

LinearFlow::Flight LinearFlow::depart(double t0, const Vector& x0) const {
  const LinearOscillator& q = coefficient_;
  const double wt = q.frequency * t0, c = std::cos(wt), s = std::sin(wt);
  Flight flight{t0,  x0[0], c, s, x0[0] - (cosine_ * c + sine_ * s + offset_), x0[1] - q.frequency * (sine_ * c - cosine_ * s),
                0.0, {}};
  flight.near = 0.05 / std::max({q.frequency, std::sqrt(q.stiffness), 2.0 * q.damping});  // 0.05^9/9! is below rounding
  const double turn[4] = {c, -s, -c, s};
  double before = x0[0], here = x0[1], force = q.amplitude, factorial = 1.0;
  for (std::size_t i = 1; i < flight.series.size(); ++i) {  // x^(i+1) = force^(i-1) - 2 b x^(i) - k x^(i-1)
    factorial *= static_cast<double>(i);
    flight.series[i] = here / factorial;
    const double next = force * turn[(i - 1) % 4] + (i == 1 ? q.constant : 0.0) - 2.0 * q.damping * here - q.stiffness * before;
    before = here;
    here = next;
    force *= q.frequency;
  }
  return flight;
}

LinearFlow::Point LinearFlow::at(const Flight& flight, double s, const Damped* known) const {
  const LinearOscillator& q = coefficient_;
  double c = flight.c, sn = flight.s;
  if (s != 0.0) {
    const double wt = q.frequency * (flight.t0 + s);
    c = std::cos(wt);
    sn = std::sin(wt);
  }
  Point point{};
  if (s <= flight.near) {
    for (std::size_t i = flight.series.size() - 1; i > 0; --i) {
      point.dx = s * (flight.series[i] + point.dx);
      point.v = static_cast<double>(i) * flight.series[i] + s * point.v;
    }
  } else {
    const Damped f = known ? *known : damped(s);
    const double b_S = q.damping * f.S;
    point.dx = (f.C + b_S) * flight.d + f.S * flight.e + cosine_ * c + sine_ * sn + offset_ - flight.x0;
    point.v = -q.stiffness * f.S * flight.d + (f.C - b_S) * flight.e + q.frequency * (sine_ * c - cosine_ * sn);
  }
  point.a = q.amplitude * c + q.constant - 2.0 * q.damping * point.v - q.stiffness * (flight.x0 + point.dx);
  point.j = -q.amplitude * q.frequency * sn - 2.0 * q.damping * point.a - q.stiffness * point.v;
  const double w2 = q.frequency * q.frequency;
  point.x4 = -q.amplitude * w2 * c - 2.0 * q.damping * point.j - q.stiffness * point.a;
  point.x5 = q.amplitude * w2 * q.frequency * sn - 2.0 * q.damping * point.x4 - q.stiffness * point.j;
  point.c = c;
  point.s = sn;
  return point;
}

std::optional<double> LinearFlow::first_crossing(const Flight& flight, const detail::LevelBarrier& barrier, double s_end,
                                                 std::size_t& evaluations) const {
  const LinearOscillator& q = coefficient_;
  const double w = q.frequency, k = q.stiffness, b = q.damping;
  const double w2 = w * w, w4 = w2 * w2, forced6 = forced_ * w4 * w2;
  const double scale = 1.0 + std::abs(barrier.level);
  const double longest = 2.5 / std::max(w, std::sqrt(k));  // beyond that the Taylor bound is useless
  const auto evaluate = [&](double s) {
    ++evaluations;
    return at(flight, s);
  };
  // A start on the barrier that is not an active guard (the Propagator has checked this) leaves it: rounding must not undo
  // this.
  double start = flight.x0 - barrier.level;
  bool leaving = std::abs(start) <= guard_tolerance * scale;
  if (leaving) start = 0.0;
  const auto gap = [&](const Point& z) { return barrier.sign * (start + z.dx); };

  double s = 0.0;
  Point z = evaluate(0.0);
  double g = gap(z), v = barrier.sign * z.v;
  const bool resting = leaving && std::abs(v) <= rest_tolerance * (1.0 + std::abs(z.a));
  double H = longest;
  while (s < s_end && evaluations < max_steps_) {  // an extremely long period would never end
    // Once a maximum within rounding of the barrier has been checked, the motion counts as leaving it.
    const bool from_barrier = leaving;
    if (leaving) {
      g = std::min(g, 0.0);
      v = std::min(v, 0.0);
      leaving = false;
    }
    const double a = resting && s == 0.0 ? std::min(barrier.sign * z.a, 0.0) : barrier.sign * z.a, j = barrier.sign * z.j;
    // Bound of the sixth derivative: that of the transient follows from the energy one derivative down, sqrt(x6^2 + k x5^2),
    // which only decays.
    const double x4 = barrier.sign * z.x4, x5 = barrier.sign * z.x5;
    const double x5_h = z.x5 - w4 * w * (sine_ * z.c - cosine_ * z.s);
    const double x4_h = z.x4 - w4 * (cosine_ * z.c + sine_ * z.s);
    const double x6_h = -2.0 * b * x5_h - k * x4_h;
    const double M6 = std::sqrt(x6_h * x6_h + k * x5_h * x5_h) + forced6;
    H = std::min({2.0 * H, longest, s_end - s});
    const double too_short = 1e-15 * (1.0 + s);
    for (;; H *= 0.5) {
      if (detail::stays_below_zero<6>({g, v, a / 2, j / 6, x4 / 24, x5 / 120, M6 / 720}, H)) break;  // none on [s, s + H]
      if (detail::stays_below_zero<5>({-v, -a, -j / 2, -x4 / 6, -x5 / 24, M6 / 120},
                                      H)) {  // the speed stays positive on it: at most one crossing
        if (g >= 0.0) return s;
        const Point end = evaluate(s + H);
        if (gap(end) < 0.0) break;
        // The root is unique: first of the Taylor polynomial, then by Halley's method, kept in the bracket.
        double lo = s, hi = s + H, root = s;
        for (int i = 0; i < 8; ++i) {
          const double h = root - s;
          const double value = g + h * (v + h * (a / 2 + h * (j / 6 + h * (x4 / 24 + h * (x5 / 120)))));
          const double slope = v + h * (a + h * (j / 2 + h * (x4 / 6 + h * (x5 / 24))));
          const double move = value / slope;
          root -= move;
          if (!(root > lo && root < hi) || std::abs(move) < 1e-6 * H) break;
        }
        for (int i = 0; i < 60; ++i) {
          if (!(root >= lo && root <= hi)) root = 0.5 * (lo + hi);
          const Point here = evaluate(root);
          const double h = gap(here);
          (h < 0.0 ? lo : hi) = root;
          const double newton = h / (barrier.sign * here.v), bend = newton * here.a / here.v;
          const double move = newton / (1.0 - 0.5 * std::clamp(bend, -1.0, 1.0));
          root -= move;
          // The error after a move is of the order of its cube times (a/v)^2 and j/v.
          const double left = std::abs(move) * (bend * bend + std::abs(move * move * here.j / here.v));
          if (std::min(std::abs(move), 20.0 * left) <= 4e-16 * (flight.t0 + root) || lo == hi) break;
        }
        return std::clamp(root, s, s + H);
      }
      if (H < too_short || (!from_barrier && detail::touches_by_rounding(g, v, a, scale))) {
        // A maximum within rounding of the barrier: check the maximum itself, once, and continue beyond it.
        const double to_top = detail::time_to_top(v, a);
        const Point top = evaluate(s + to_top);
        if (gap(top) > 0.0 || !(barrier.sign * top.a < 0.0)) return std::min(s + to_top, s_end);
        s += to_top;
        z = top;
        g = gap(top);
        v = barrier.sign * top.v;
        leaving = true;
        break;
      }
    }
    if (leaving) {
      H = longest;
      continue;
    }
    s += H;
    if (s >= s_end) break;
    z = evaluate(s);
    g = gap(z);
    v = barrier.sign * z.v;
    if (g >= 0.0) return s;  // by rounding only: the bound shows g < 0
  }
  return std::nullopt;
}

void LinearFlow::carry(const FlowTask& task, const Vector& x0, Segment& out) const {
  const Flight flight = depart(task.t0, x0);
  double duration = task.t_end - task.t0;
  out.t0 = task.t0;
  out.x0 = x0;
  out.end = FlowEnd::time;
  out.evaluations = 0;
  double level = 0.0;
  for (const detail::LevelBarrier& barrier :
       task.watch_events ? std::span<const detail::LevelBarrier>(barriers_) : std::span<const detail::LevelBarrier>()) {
    const std::optional<double> root = first_crossing(flight, barrier, duration, out.evaluations);
    if (root && (*root < duration || out.end == FlowEnd::time)) {
      duration = *root;
      out.end = FlowEnd::event;
      out.event = barrier.event;
      level = barrier.level;
    }
    if (out.evaluations >= max_steps_) {
      out.end = FlowEnd::failed;
      out.t1 = task.t0;
      out.x1 = x0;
      return;
    }
  }
  out.t1 = out.end == FlowEnd::time ? task.t_end : task.t0 + duration;
  const bool tangent = task.sensitivity != Sensitivity::none;
  const Damped f = tangent ? damped(duration) : Damped{};
  if (duration > 0.0) {
    const Point end = at(flight, duration, tangent ? &f : nullptr);
    out.x1.resize(2);
    out.x1 << flight.x0 + end.dx, end.v;
  } else {
    out.x1 = x0;
  }
  if (out.end == FlowEnd::event) out.x1[0] = level;
  if (tangent) sensitivities(f, duration, task.sensitivity == Sensitivity::state_and_parameters, out);
}

void LinearFlow::sensitivities(const Damped& f, double s, bool with_parameters, Segment& out) const {
  const double b = coefficient_.damping, k = coefficient_.stiffness, w = coefficient_.frequency;
  Matrix2 Phi;
  Phi << f.C + b * f.S, f.S, -k * f.S, f.C - b * f.S;
  out.Phi = Phi;
  out.divergence = -2.0 * b * s;
  if (!with_parameters) return;
  out.Psi.resize(2, active_dp_.cols());
  if (active_dp_.cols() == 0) return;
  const double C_q = -s * f.S / 2.0, S_q = dS_dq2(s, f);
  Matrix2 Phi_b, Phi_k;
  Phi_b << C_q * -2.0 * b + f.S + b * S_q * -2.0 * b, S_q * -2.0 * b, -k * S_q * -2.0 * b,
      C_q * -2.0 * b - f.S - b * S_q * -2.0 * b;
  Phi_b -= s * Phi;
  Phi_k << C_q + b * S_q, S_q, -f.S - k * S_q, C_q - b * S_q;
  // z_p(t) = B(t) (cosine, sine, offset) and its derivatives in the five coefficients.
  const auto particular = [&](double t, Eigen::Matrix<double, 2, 5>& dq) {
    const double c = std::cos(w * t), sn = std::sin(w * t);
    Eigen::Matrix<double, 2, 3> B;
    B << c, sn, 1.0, -w * sn, w * c, 0.0;
    dq = B * particular_dq_;
    dq(0, 3) += t * (sine_ * c - cosine_ * sn);
    dq(1, 3) += (sine_ * c - cosine_ * sn) - w * t * (cosine_ * c + sine_ * sn);
    return Vector2(B * Eigen::Vector3d(cosine_, sine_, offset_));
  };
  Eigen::Matrix<double, 2, 5> start_dq, end_dq;
  const Vector2 deviation = out.x0 - particular(out.t0, start_dq);
  particular(out.t1, end_dq);
  Eigen::Matrix<double, 2, 5> z_dq = end_dq - Phi * start_dq;
  z_dq.col(0) += Phi_b * deviation;
  z_dq.col(1) += Phi_k * deviation;
  out.Psi.noalias() = z_dq * active_dp_;
}

}  // namespace graze
