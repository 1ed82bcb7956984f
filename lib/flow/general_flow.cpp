// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/flow/general_flow.hpp>

#include <graze/lib/system/guard_rounding.hpp>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <gsl/gsl_roots.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace graze {

namespace {

struct StepDeleter {
  void operator()(gsl_odeiv2_step* step) const { gsl_odeiv2_step_free(step); }
};
struct SolverDeleter {
  void operator()(gsl_root_fsolver* solver) const { gsl_root_fsolver_free(solver); }
};
using StepPointer = std::unique_ptr<gsl_odeiv2_step, StepDeleter>;

/// GSL's default handler aborts the process; every status is checked here instead.
void switch_off_gsl_abort() {
  static const bool done = [] {
    gsl_set_error_handler_off();
    return true;
  }();
  static_cast<void>(done);
}

/// Root of f on a bracket with f(lo) f(hi) <= 0, by Brent's method, to rounding.
template <class F> double brent(F&& f, double lo, double hi) {
  std::unique_ptr<gsl_root_fsolver, SolverDeleter> solver(gsl_root_fsolver_alloc(gsl_root_fsolver_brent));
  gsl_function function{[](double s, void* self) { return (*static_cast<const std::remove_reference_t<F>*>(self))(s); },
                        const_cast<void*>(static_cast<const void*>(&f))};
  if (gsl_root_fsolver_set(solver.get(), &function, lo, hi) != GSL_SUCCESS) return hi;
  double root = hi;
  for (int i = 0; i < 100; ++i) {
    if (gsl_root_fsolver_iterate(solver.get()) != GSL_SUCCESS) break;
    root = gsl_root_fsolver_root(solver.get());
    if (gsl_root_test_interval(gsl_root_fsolver_x_lower(solver.get()), gsl_root_fsolver_x_upper(solver.get()), 1e-16, 1e-15) !=
        GSL_CONTINUE)
      break;
  }
  return root;
}

}  // namespace

struct GeneralFlow::Integrator {
  SharedSystem system;
  const Mode& mode;  // of the system
  Vector p;
  std::vector<std::size_t> active;
  FlowOptions options;
  std::vector<std::size_t> events;  // of this mode
  Eigen::Index n, m;
  // Start of the segment. The state is integrated as its deviation from it, because a short flight off a barrier would be lost
  // in the rounding of x.
  Vector origin;
  Vector x, f;
  Matrix A, f_p;
  std::array<StepPointer, 3> steppers;  // by sensitivity; made on demand, as most are never used
  std::vector<double> y, y_next, error, slope, slope_next, y_state, error_state;
  std::size_t evaluations = 0;
  double max_step;

  Integrator(const SharedSystem& s, std::size_t index, const Vector& parameters, std::span<const std::size_t> act,
             const FlowOptions& o)
      : system(s), mode(s->modes[index]), p(parameters), active(act.begin(), act.end()), options(o),
        n(static_cast<Eigen::Index>(s->states)), m(static_cast<Eigen::Index>(act.size())), x(n), f(n), A(n, n),
        f_p(n, static_cast<Eigen::Index>(s->parameters.size())) {
    switch_off_gsl_abort();
    for (std::size_t i = 0; i < s->events.size(); ++i)
      if (s->events[i].from == index) events.push_back(i);
    max_step = options.max_step;
    if (max_step <= 0.0) max_step = is_forced(s) ? forcing_period(s, p) / 16.0 : std::numeric_limits<double>::infinity();
    const auto largest = static_cast<std::size_t>(size(Sensitivity::state_and_parameters));
    for (auto* v : {&y, &y_next, &error, &slope, &slope_next}) v->resize(largest);
    y_state.resize(s->states);
    error_state.resize(s->states);
  }

  Eigen::Index size(Sensitivity sensitivity) const {
    if (sensitivity == Sensitivity::none) return n;
    return n + n * n + 1 + (sensitivity == Sensitivity::state ? 0 : n * m);
  }
  gsl_odeiv2_step* stepper(Sensitivity sensitivity) {
    StepPointer& one = steppers[static_cast<std::size_t>(sensitivity)];
    if (!one) one.reset(gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, static_cast<std::size_t>(size(sensitivity))));
    return one.get();
  }

  /// Field of x | Phi | divergence | Psi; `total`, one of the values of size(), says how many of them are present.
  void equations(double t, const double* in, double* out, Eigen::Index total) {
    ++evaluations;
    x = origin + Eigen::Map<const Vector>(in, n);
    mode.field(t, x, p, f);
    Eigen::Map<Vector>(out, n) = f;
    if (total == n) return;
    mode.field_dx(t, x, p, A);
    Eigen::Map<Matrix>(out + n, n, n).noalias() = A * Eigen::Map<const Matrix>(in + n, n, n);
    out[n + n * n] = A.trace();
    const Eigen::Index before = n + n * n + 1;
    if (total == before) return;
    mode.field_dp(t, x, p, f_p);
    Eigen::Map<Matrix> psi_out(out + before, n, m);
    psi_out.noalias() = A * Eigen::Map<const Matrix>(in + before, n, m);
    for (Eigen::Index k = 0; k < m; ++k)
      psi_out.col(k) += f_p.col(static_cast<Eigen::Index>(active[static_cast<std::size_t>(k)]));
  }

  struct Bound {
    Integrator* self;
    Eigen::Index total;
  };
  static int callback(double t, const double in[], double out[], void* bound) {
    const auto* b = static_cast<Bound*>(bound);
    b->self->equations(t, in, out, b->total);
    return std::isfinite(Eigen::Map<const Vector>(out, b->self->n).sum()) ? GSL_SUCCESS : GSL_EBADFUNC;
  }

  /// One guard at an instant of the current step.
  struct Node {
    double s, g, g_dot;
  };
  double step_start = 0.0;  // of the step under inspection; y and slope hold its start

  Node node_at(const Guard& guard, double s, const double* state) {
    x = origin + Eigen::Map<const Vector>(state, n);
    const double t = step_start + s;
    mode.field(t, x, p, f);
    const Vector here = x, field_here = f;
    return {s, guard_value(guard, t, here, state), transversality(guard, t, here, field_here, p)};
  }
  double guard_value(const Guard& guard, double t, const Vector& here, const double* deviation) const {
    if (!guard.level) return guard.value(t, here, p);
    const auto coordinate = static_cast<Eigen::Index>(guard.level->coordinate);
    double start = origin[coordinate] - p[static_cast<Eigen::Index>(guard.level->level)];
    if (std::abs(start) <= guard_tolerance * (1.0 + origin.lpNorm<Eigen::Infinity>())) start = 0.0;
    return guard.level->sign * (start + deviation[coordinate]);
  }
  Node node_inside(const Guard& guard, double s) {
    std::copy_n(y.begin(), n, y_state.begin());
    Bound bound{this, n};
    gsl_odeiv2_system equations_of_state{callback, nullptr, static_cast<std::size_t>(n), &bound};
    gsl_odeiv2_step_apply(stepper(Sensitivity::none), step_start, s, y_state.data(), error_state.data(), slope.data(), nullptr,
                          &equations_of_state);
    return node_at(guard, s, y_state.data());
  }

  std::optional<double> first_crossing(const Guard& guard, const Node& a, const Node& b, int depth) {
    const double H = b.s - a.s;
    const double c1 = a.g + a.g_dot * H / 3.0, c2 = b.g - b.g_dot * H / 3.0;
    const bool beyond = a.g < 0.0 ? b.g >= 0.0 : b.g > 0.0;  // staying on a guard from the start is no crossing
    const auto [low, high] = std::minmax({a.g, c1, c2, b.g});
    const double spread = high - low;
    if (high < -0.25 * spread) return std::nullopt;
    if (H < 1e-15 * (1.0 + std::abs(step_start)) || depth > 60) return beyond ? std::optional(b.s) : std::nullopt;
    const Node mid = node_inside(guard, 0.5 * (a.s + b.s));
    const auto halves = [&]() -> std::optional<double> {
      if (const auto left = first_crossing(guard, a, mid, depth + 1)) return left;
      return mid.g > 0.0 ? std::nullopt : first_crossing(guard, mid, b, depth + 1);
    };
    const double misfit = std::abs(mid.g - (a.g + 3.0 * c1 + 3.0 * c2 + b.g) / 8.0);
    // Within rounding of the barrier halving would not end.
    const double rounding = 4e-15 * (1.0 + origin.lpNorm<Eigen::Infinity>());
    if (misfit > 1e-3 * spread + rounding) return halves();
    if (high < -20.0 * misfit - rounding) return std::nullopt;
    const auto value = [&](double s) { return node_inside(guard, s).g; };
    if (beyond) {
      if (a.g < 0.0 && a.g_dot > 0.0 && b.g_dot > 0.0 && c2 >= c1) return brent(value, a.s, b.s);  // it rises throughout
      return halves();
    }
    // If it rises (or falls) at both ends, a maximum and a minimum lie inside: separate them.
    if ((a.g_dot > 0.0) == (b.g_dot > 0.0) && std::max(c1, c2) > std::max(a.g, b.g) + rounding) return halves();
    if (a.g_dot > 0.0 && b.g_dot < 0.0) {  // a maximum inside: does it reach the barrier?
      const double top = brent([&](double s) { return node_inside(guard, s).g_dot; }, a.s, b.s);
      if (value(top) > 0.0) return a.g < 0.0 ? brent(value, a.s, top) : a.s;
    }
    return std::nullopt;
  }
};

GeneralFlow::GeneralFlow(const SharedSystem& system, std::size_t mode, const Vector& p, std::span<const std::size_t> active,
                         const FlowOptions& options)
    : integrator_(std::make_unique<Integrator>(system, mode, p, active, options)) {}
GeneralFlow::GeneralFlow(GeneralFlow&&) noexcept = default;
GeneralFlow& GeneralFlow::operator=(GeneralFlow&&) noexcept = default;
GeneralFlow::~GeneralFlow() = default;

void GeneralFlow::field(double t, const Vector& x, Vector& out) const { integrator_->mode.field(t, x, integrator_->p, out); }

void GeneralFlow::carry(const FlowTask& task, const Vector& x0, Segment& out) {
  Integrator& I = *integrator_;
  const Eigen::Index n = I.n, total = I.size(task.sensitivity);
  gsl_odeiv2_step* const stepper = I.stepper(task.sensitivity);
  Integrator::Bound bound{&I, total};
  gsl_odeiv2_system equations{Integrator::callback, nullptr, static_cast<std::size_t>(total), &bound};
  const auto count = static_cast<std::size_t>(total);
  out.t0 = task.t0;
  out.x0 = x0;
  out.end = FlowEnd::failed;
  I.evaluations = 0;
  std::fill(I.y.begin(), I.y.end(), 0.0);
  I.origin = x0;
  if (total > n) Eigen::Map<Matrix>(I.y.data() + n, n, n).setIdentity();
  I.equations(task.t0, I.y.data(), I.slope.data(), total);

  const auto finish = [&](FlowEnd end, double t1, const double* last) {
    out.end = end;
    out.t1 = t1;
    out.x1 = I.origin + Eigen::Map<const Vector>(last, n);
    out.evaluations = I.evaluations;
    if (end == FlowEnd::event) {
      const auto& level = I.system->events[out.event].guard.level;
      if (level) out.x1[static_cast<Eigen::Index>(level->coordinate)] = I.p[static_cast<Eigen::Index>(level->level)];
    }
    if (task.sensitivity == Sensitivity::none) return;
    out.Phi = Eigen::Map<const Matrix>(last + n, n, n);
    out.divergence = last[n + n * n];
    out.Psi = Eigen::Map<const Matrix>(last + n + n * n + 1, n, task.sensitivity == Sensitivity::state_and_parameters ? I.m : 0);
  };

  const auto relative_error = [&] {  // largest local error of the last step, infinite if any is not a number
    double worst = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double start = i < I.system->states ? x0[static_cast<Eigen::Index>(i)] : 0.0;
      const double relative = std::abs(I.error[i]) / (1.0 + std::abs(start + I.y_next[i]));
      worst = std::max(worst, relative);
      sum += relative;
    }
    return std::isfinite(sum) ? worst : std::numeric_limits<double>::infinity();
  };

  constexpr double shortest_step = 1e-14;
  double t = task.t0, h = std::min(I.max_step, 0.01 * (task.t_end - task.t0) + 1e-6);
  bool first = true;
  for (std::size_t step = 0; step < I.options.max_steps; ++step) {
    const double left = task.t_end - t;
    if (left <= 0.0) return finish(FlowEnd::time, task.t_end, I.y.data());
    const bool last_step = h >= left * (1.0 - 1e-12);
    if (last_step) h = left;
    const auto apply = [&](double size) {
      std::copy_n(I.y.begin(), count, I.y_next.begin());
      return gsl_odeiv2_step_apply(stepper, t, size, I.y_next.data(), I.error.data(), I.slope.data(), I.slope_next.data(),
                                   &equations);
    };
    if (apply(h) != GSL_SUCCESS) {
      h *= 0.25;
      if (h < shortest_step) break;
      continue;
    }
    const double worst = relative_error();
    const double factor = 0.9 * std::pow(I.options.tolerance / std::max(worst, 1e-30), 1.0 / 8.0);
    if (worst > I.options.tolerance) {
      h *= std::clamp(factor, 0.1, 0.9);
      if (h < shortest_step) break;
      continue;
    }
    if (!std::isfinite(worst)) break;
    I.step_start = t;
    std::optional<double> crossing;
    for (const std::size_t event : task.watch_events ? std::span<const std::size_t>(I.events) : std::span<const std::size_t>()) {
      const Guard& guard = I.system->events[event].guard;
      Integrator::Node a = I.node_at(guard, 0.0, I.y.data());
      if (first && std::abs(a.g) <= guard_width(guard_scale(guard, t, x0, I.p), t, x0)) {
        // A start on the guard that is not active (the Propagator has checked this) leaves it: rounding must not undo this.
        a.g = std::min(a.g, 0.0);
        a.g_dot = std::min(a.g_dot, 0.0);
      }
      const Integrator::Node b = I.node_at(guard, h, I.y_next.data());
      const std::optional<double> found = I.first_crossing(guard, a, b, 0);
      if (found && (!crossing || *found < *crossing)) {
        crossing = found;
        out.event = event;
      }
    }
    if (crossing) {
      if (*crossing < h) {
        if (apply(*crossing) != GSL_SUCCESS) break;
        if (relative_error() > I.options.tolerance && *crossing > 1e-10) {  // the whole step was accurate by chance: take two
          h = 0.5 * *crossing;
          continue;
        }
      }
      return finish(FlowEnd::event, std::min(t + *crossing, task.t_end), I.y_next.data());
    }
    first = false;
    std::swap(I.y, I.y_next);
    std::swap(I.slope, I.slope_next);
    t = last_step ? task.t_end : t + h;
    h = std::min(I.max_step, h * std::clamp(factor, 0.5, 4.0));
  }
  finish(FlowEnd::failed, t, I.y.data());
}

}  // namespace graze
