// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/flow/cubic_flow.hpp>

#include <graze/lib/flow/bernstein.hpp>
#include <graze/lib/flow/cubic_series.hpp>
#include <graze/lib/flow/hertz_step.hpp>

#include <algorithm>
#include <cmath>

namespace graze {

namespace {

using C = CubicOscillator;

constexpr std::size_t order = detail::cubic_order;
using Coefficients = std::span<const double, order + 1>;

/// Whether the gap stays below zero over a whole step, by its Bernstein coefficients up to degree 8 with a bound of the
/// remaining terms. This suffices for nearly all steps.
bool stays_below(Coefficients x, double sign, double at_start, double at_start_slope, double length) {
  constexpr std::size_t degree = 8;
  std::array<double, degree + 1> power;  // powers of the length, by squares for a shorter chain of dependencies
  power[0] = 1.0;
  power[1] = length;
#pragma GCC unroll 8
  for (std::size_t k = 2; k <= degree; ++k) power[k] = power[k / 2] * power[k - k / 2];
  std::array<double, degree + 1> a;
  a[0] = at_start;
  a[1] = at_start_slope * length;
  double rest = 0.0;
#pragma GCC unroll 8
  for (std::size_t k = 2; k <= degree; ++k) a[k] = sign * x[k] * power[k];
#pragma GCC unroll 8
  for (std::size_t k = 1; k + degree <= order; ++k) rest += std::abs(x[degree + k]) * power[k];
  a[degree] += rest * power[degree];  // sum_{k > 8} |a_k| u^k <= u^8 sum |a_k|, u = t/length in [0, 1]
  return detail::stays_below_zero<degree>(a, 1.0);
}

/// sign (x - level) on one step of the flight, a polynomial in the time since the step's start, with its derivatives.
struct GapPolynomial {
  Coefficients a;  // without a[0]: the gap is `start` plus the displacement since then
  double sign;
  double start;  // sign (x - level) at the step's start
  double sixth;  // bound of |sixth derivative| / 720 over the step

  GapPolynomial(Coefficients x, double direction, double at_start, double length)
      : a(x), sign(direction), start(at_start), sixth(0.0) {
    double power = 1.0, binomial = 1.0;  // (i over 6)
    for (std::size_t i = 6; i <= order; ++i) {
      sixth += binomial * std::abs(a[i]) * power;
      power *= length;
      binomial *= static_cast<double>(i + 1) / static_cast<double>(i - 5);
    }
  }
  std::array<double, 6> at_start() const { return {start, sign * a[1], sign * a[2], sign * a[3], sign * a[4], sign * a[5]}; }
  /// The gap, then its derivatives over factorials up to number `Last`.
  template <std::size_t Last> std::array<double, Last + 1> at(double h) const {
    std::array<double, Last + 1> z{};
    for (std::size_t k = order; k > 0; --k) {  // Horner's scheme for all derivatives together
      for (std::size_t m = Last; m > 0; --m) z[m] = z[m - 1] + h * z[m];
      z[0] = a[k] + h * z[0];
    }
    for (std::size_t m = Last; m > 0; --m) z[m] = sign * (z[m - 1] + h * z[m]);
    z[0] = start + sign * (h * z[0]);
    return z;
  }
};

/// Approximate root in [0, H] of the polynomial of degree 5 with coefficients z: the start of the search.
double near_root(const std::array<double, 6>& z, double H) {
  double root = 0.0;
  for (int i = 0; i < 8; ++i) {
    const double value = z[0] + root * (z[1] + root * (z[2] + root * (z[3] + root * (z[4] + root * z[5]))));
    const double slope = z[1] + root * (2.0 * z[2] + root * (3.0 * z[3] + root * (4.0 * z[4] + root * (5.0 * z[5]))));
    const double move = value / slope;
    root -= move;
    if (!(root > 0.0 && root < H)) return i == 0 ? std::clamp(root, 0.0, H) : 0.5 * H;
    if (std::abs(move) < 1e-6 * H) break;
  }
  return root;
}

/// First h in [0, length] where the gap rises through 0. `leaving`: the flight starts on the barrier and leaves it (the
/// Propagator has checked that the guard is not active); rounding must not undo this.
std::optional<double> first_crossing(const GapPolynomial& gap, double length, double t, double scale, bool leaving) {
  double s = 0.0, H = length;
  std::array<double, 6> z = gap.at_start();
  const bool resting = leaving && std::abs(z[1]) <= rest_tolerance * (1.0 + 2.0 * std::abs(z[2]));
  while (s < length) {
    // Once a maximum within rounding of the barrier has been checked, the motion counts as leaving it.
    const bool from_barrier = leaving;
    if (leaving) {
      z[0] = std::min(z[0], 0.0);
      z[1] = std::min(z[1], 0.0);
      if (resting && s == 0.0) z[2] = std::min(z[2], 0.0);
      leaving = false;
    }
    const double g = z[0], v = z[1], a = 2.0 * z[2];
    if (!from_barrier && g >= 0.0) return s;  // by rounding only: the bound shows g < 0
    H = std::min(2.0 * H, length - s);
    const double too_short = 1e-15 * (1.0 + std::abs(t));
    for (;; H *= 0.5) {
      if (detail::stays_below_zero<6>({g, v, z[2], z[3], z[4], z[5], gap.sixth}, H)) break;  // no crossing on [s, s + H]
      if (detail::stays_below_zero<5>({-v, -a, -3.0 * z[3], -4.0 * z[4], -5.0 * z[5], 6.0 * gap.sixth}, H)) {
        // The speed stays positive on it: at most one crossing.
        if (gap.at<0>(s + H)[0] < 0.0) break;
        double lo = s, hi = s + H, root = s + near_root(z, H);
        for (int i = 0; i < 60; ++i) {
          const std::array<double, 4> here = gap.at<3>(root);
          (here[0] < 0.0 ? lo : hi) = root;
          const double newton = here[0] / here[1], bend = 2.0 * newton * here[2] / here[1];
          const double move = newton / (1.0 - 0.5 * std::clamp(bend, -1.0, 1.0));
          root -= move;
          if (!(root >= lo && root <= hi)) root = 0.5 * (lo + hi);
          // The error after a move is of the order of its cube times (a/v)^2 and j/v.
          const double remains = std::abs(move) * (bend * bend + std::abs(6.0 * move * move * here[3] / here[1]));
          if (std::min(std::abs(move), 20.0 * remains) <= 4e-16 * root || lo == hi) break;
        }
        return std::clamp(root, s, s + H);
      }
      if (H < too_short || (!from_barrier && detail::touches_by_rounding(g, v, a, scale))) {
        // A maximum within rounding of the barrier: check the maximum itself, once, and continue beyond it.
        const double to_top = detail::time_to_top(v, a);
        const std::array<double, 6> top = gap.at<5>(s + to_top);
        if (top[0] > 0.0 || !(top[2] < 0.0)) return std::min(s + to_top, length);
        s += to_top;
        z = top;
        leaving = true;
        break;
      }
    }
    if (leaving) {
      H = length;
      continue;
    }
    s += H;
    if (s < length) z = gap.at<5>(s);
  }
  return std::nullopt;
}

}  // namespace

bool CubicFlow::applies(const HybridSystem& system, std::size_t mode) {
  return system.states == 2 && detail::guards_are_levels(system, mode);
}

CubicFlow::CubicFlow(const HybridSystem& system, std::size_t mode, const Vector& p, std::span<const std::size_t> active,
                     const CubicOscillator& oscillator, const FlowOptions& options)
    : oscillator_(oscillator), options_(options), sources_(oscillator.dp, active) {
  barriers_ = detail::level_barriers(system, mode, p);
}

void CubicFlow::field(double t, const Vector& x, Vector& out) const {
  const auto& q = oscillator_.value;
  out[0] = x[1];
  out[1] = q[C::amplitude] * std::cos(q[C::frequency] * t) + q[C::constant] - 2.0 * q[C::damping] * x[1] -
           q[C::stiffness] * x[0] - q[C::cubic] * x[0] * x[0] * x[0];
}

void CubicFlow::carry(const FlowTask& task, const Vector& x0, Segment& out) const {
  if (task.sensitivity != Sensitivity::state_and_parameters || sources_.coefficients.empty()) {
    carry_with<1>(task, x0, out);
    out.Psi.setZero(2, task.sensitivity == Sensitivity::state_and_parameters ? sources_.dp.cols() : 0);
    return;
  }
  if (sources_.coefficients.size() <= 4) return carry_with<2>(task, x0, out);
  static_assert(C::count <= 8);
  carry_with<3>(task, x0, out);
}

template <std::size_t Quads> void CubicFlow::carry_with(const FlowTask& task, const Vector& x0, Segment& out) const {
  const double duration = task.t_end - task.t0;
  typename detail::CubicSeries<Quads>::State z;
  z.v = x0[1];
  const bool tangent = task.sensitivity != Sensitivity::none;
  if (tangent) z.dx[0] = z.dv[1] = 1.0;
  out.t0 = task.t0;
  out.x0 = x0;
  out.end = FlowEnd::failed;
  out.evaluations = 0;
  double level = 0.0;

  const auto finish = [&](FlowEnd end, double s) {
    out.end = end;
    out.t1 = end == FlowEnd::time ? task.t_end : task.t0 + s;
    out.x1.resize(2);
    out.x1 << (end == FlowEnd::event ? level : x0[0] + z.moved), z.v;
    if (tangent) {
      out.divergence = -2.0 * oscillator_.value[C::damping] * s;
      out.Phi.resize(2, 2);
      out.Phi << z.dx[0], z.dx[1], z.dv[0], z.dv[1];
    }
    if constexpr (Quads > 1) {
      Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, C::count> columns(2, sources_.dp.rows());
      for (std::size_t i = 0; i < sources_.coefficients.size(); ++i)
        columns.col(static_cast<Eigen::Index>(i)) << z.dx[2 + i], z.dv[2 + i];
      out.Psi.noalias() = columns * sources_.dp;
    }
  };

  // The last two terms of a step are within a quarter of the tolerance: the truncation error is below a twentieth of it.
  const double allowed = 0.25 * options_.tolerance;
  detail::CubicSeries<Quads> series(oscillator_, sources_.coefficients, x0[0]);
  double s = 0.0;
  for (std::size_t step = 0; step < options_.max_steps; ++step) {
    const double left = duration - s;
    if (left <= 0.0) return finish(FlowEnd::time, duration);
    if (step % 16 == 0) {  // the phase must not drift from the time
      const double phase = oscillator_.value[C::frequency] * (task.t0 + s);
      z.cosine = std::cos(phase);
      z.sine = std::sin(phase);
    }
    series.expand(task.t0 + s, z);
    out.evaluations += order;
    const double last = series.last(), before = series.before();
    if (!std::isfinite(last + before)) break;
    double h = std::min(detail::rough_root(allowed, last, order), detail::rough_root(allowed, before, order - 1));
    if (!(h > 0.0)) break;
    const bool to_end = h >= left * (1.0 - 1e-12);
    if (to_end) h = left;
    std::optional<double> crossing;
    for (const detail::LevelBarrier& barrier :
         task.watch_events ? std::span<const detail::LevelBarrier>(barriers_) : std::span<const detail::LevelBarrier>()) {
      const double scale = 1.0 + std::abs(barrier.level);
      double start = x0[0] - barrier.level;
      const bool on_barrier = std::abs(start) <= guard_tolerance * scale;
      if (on_barrier) start = 0.0;
      const double gap_start = barrier.sign * (start + z.moved), slope = barrier.sign * series.position()[1];
      const bool leaves = on_barrier && step == 0;
      if ((leaves || gap_start < 0.0) &&
          stays_below(series.position(), barrier.sign, gap_start, leaves ? std::min(slope, 0.0) : slope, h))
        continue;
      const GapPolynomial gap(series.position(), barrier.sign, gap_start, h);
      const std::optional<double> root = first_crossing(gap, h, task.t0 + s, scale, leaves);
      if (root && (!crossing || *root < *crossing)) {
        crossing = root;
        out.event = barrier.event;
        level = barrier.level;
      }
    }
    z = series.at(crossing ? *crossing : h);
    if (crossing) return finish(FlowEnd::event, s + *crossing);
    s = to_end ? duration : s + h;
  }
  finish(FlowEnd::failed, s);
}

}  // namespace graze
