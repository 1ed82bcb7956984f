// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/lib/motion/rest.hpp>
#include <graze/lib/motion/transition.hpp>
#include <graze/lib/system/saltation.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace graze {

namespace {

/// Number of bounces a period from which the pressing acceleration is nearly constant over one bounce: the neglected change of
/// the action in a bounce is of the order (2 pi / number)^2.
constexpr std::size_t many_bounces = 64;
/// Largest deviation of the decrease of the action's logarithm from the expected one, relative to the latter.
constexpr double decrease_tolerance = 0.5;

/// A state is the state of rest up to this, relative to 1 + |x|: the error of integration with a moving stop.
constexpr double rest_distance = 1e-9;

bool is_rest(const Vector& x, const Vector& rest) {
  return (x - rest).lpNorm<Eigen::Infinity>() <= rest_distance * (1.0 + rest.lpNorm<Eigen::Infinity>());
}

double divergence(const HybridSystem& system, const Event& event, double t, const Vector& x, const Vector& p) {
  Matrix J(x.size(), x.size());
  system.modes[event.from].field_dx(t, x, p, J);
  return J.trace();
}

/// (f+ - D_x g f- - D_t g) / (dh/dt) of an impact at the state x that ends in the sticking mode, in the limit of zero speed.
/// Both vanish there; the limit is the ratio of their derivatives along the direction of the speed that the reset removes.
Vector slope_at_rest(const HybridSystem& system, const Event& holding, const Matrix& reset_dx, double t, const Vector& x,
                     const Vector& p) {
  constexpr double speed = 1e-4;  // central differences with one Richardson step
  const Eigen::Index n = x.size();
  const Reset& reset = holding.accumulation->reset;
  Vector gradient(n), slope = Vector::Zero(n);
  holding.guard.dx(t, x, p, gradient);
  // The reset removes a distance, which the guard sees, and a speed, which it does not.
  const Matrix taken = Matrix::Identity(n, n) - reset_dx;
  Eigen::Index far = 0;
  (gradient.transpose() * taken).cwiseAbs().maxCoeff(&far);
  const double reach = gradient.dot(taken.col(far));
  if (reach == 0.0) return slope;
  const Matrix speeds = taken - taken.col(far) * (gradient.transpose() * taken) / reach;
  Eigen::Index fast = 0;
  if (speeds.colwise().norm().maxCoeff(&fast) == 0.0) return slope;
  const Vector direction = speeds.col(fast).normalized();
  Vector f(n), held(n), after(n), reset_dt(n);
  Matrix J(n, n);
  const auto at = [&](double s, double& rate) {
    const Vector before = x + s * direction;
    system.modes[holding.to].field(t, before, p, f);
    rate = transversality(holding.guard, t, before, f, p);
    reset.map(t, before, p, after);
    system.modes[holding.accumulation->sticking_mode].field(t, after, p, held);
    reset.dx(t, before, p, J);
    reset_dt.setZero();
    if (reset.dt) reset.dt(t, before, p, reset_dt);
    return Vector(held - J * f - reset_dt);
  };
  const auto difference = [&](double s, double& rate) {
    double up = 0.0, down = 0.0;
    const Vector above = at(s, up), below = at(-s, down);
    rate = (up - down) / (2.0 * s);
    return Vector((above - below) / (2.0 * s));
  };
  double rough_rate = 0.0, fine_rate = 0.0;
  const Vector rough = difference(speed, rough_rate), fine = difference(0.5 * speed, fine_rate);
  slope = (4.0 * fine - rough) / (4.0 * fine_rate - rough_rate);
  return slope;
}

}  // namespace

const Event* holding_event(const HybridSystem& system, std::size_t mode) {
  const auto event = std::find_if(system.events.begin(), system.events.end(),
                                  [&](const Event& one) { return one.accumulation && one.accumulation->sticking_mode == mode; });
  return event == system.events.end() ? nullptr : &*event;
}

bool loses_energy(const Event& event, const Vector& p) { return !event.log_volume_change || event.log_volume_change(p) < 0.0; }

namespace {

/// Gradients of constraints (rows of C) and their directions (columns of D).
void gradients_and_directions(std::span<const Constraint* const> constraints, double t, const Vector& x, const Vector& p,
                              Matrix& C, Matrix& D) {
  const auto count = std::ssize(constraints);
  C.resize(count, x.size());
  D.resize(x.size(), count);
  Vector line(x.size());
  for (Eigen::Index k = 0; k < count; ++k) {
    const Constraint& one = *constraints[static_cast<std::size_t>(k)];
    one.dx(t, x, p, line);
    C.row(k) = line;
    one.direction(t, x, p, line);
    D.col(k) = line;
  }
}

/// Index of the only nonzero entry; empty if there are several or none.
std::optional<Eigen::Index> only_entry(const Vector& line) {
  if ((line.array() != 0.0).count() != 1) return std::nullopt;
  Eigen::Index place = 0;
  line.cwiseAbs().maxCoeff(&place);
  return place;
}

}  // namespace

std::optional<ConstraintMap> constraint_map(const HybridSystem& system, std::span<const Constraint* const> constraints,
                                            const HybridState& at, const Vector& p, std::span<const std::size_t> active) {
  const auto bounces_for_ever = [&](const Event& event) {
    return event.accumulation && event.accumulation->sticking_mode == at.mode && !loses_energy(event, p);
  };
  if (std::any_of(system.events.begin(), system.events.end(), bounces_for_ever)) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(system.states), count = std::ssize(constraints);
  const auto parameters = std::ssize(active);
  Matrix C, D, C_dp = Matrix::Zero(count, parameters);
  gradients_and_directions(constraints, at.t, at.x, p, C, D);
  Vector line_dp(p.size());
  for (Eigen::Index k = 0; k < count && parameters > 0; ++k) {
    const Constraint& one = *constraints[static_cast<std::size_t>(k)];
    if (!one.dp) continue;
    one.dp(at.t, at.x, p, line_dp);
    for (Eigen::Index i = 0; i < parameters; ++i)
      C_dp(k, i) = line_dp[static_cast<Eigen::Index>(active[static_cast<std::size_t>(i)])];
  }
  const Eigen::FullPivLU<Matrix> CD(C * D);
  if (!CD.isInvertible()) return std::nullopt;
  ConstraintMap map{Matrix::Identity(n, n) - D * CD.solve(C), Matrix(n, parameters)};
  if (parameters > 0) map.dp = -D * CD.solve(C_dp);
  // C dx = 0 and dx D = 0: exactly, where that makes a row or a column zero. Its rounding would be a multiplier.
  for (Eigen::Index k = 0; k < count; ++k) {
    if (const auto fixed = only_entry(Vector(C.row(k)))) map.dx.row(*fixed).setZero();
    if (const auto driven = only_entry(Vector(D.col(k)))) map.dx.col(*driven).setZero();
  }
  return map;
}

bool settle_on_constraints(const HybridSystem& system, std::size_t mode, double t, const Vector& p, Vector& x, double farthest) {
  std::vector<const Constraint*> constraints;
  for (const Constraint& one : system.modes[mode].constraints) constraints.push_back(&one);
  const auto count = std::ssize(constraints);
  const double size = 1.0 + x.lpNorm<Eigen::Infinity>();
  constexpr double rounding = 1e-15;
  constexpr int most_steps = 8;
  Vector values(count), at = x;
  const auto evaluate = [&] {
    for (Eigen::Index k = 0; k < count; ++k) values[k] = constraints[static_cast<std::size_t>(k)]->value(t, at, p);
    return count > 0 ? values.lpNorm<Eigen::Infinity>() : 0.0;
  };
  Matrix C, D;
  double off = evaluate();
  for (int step = 0; step < most_steps && off > rounding * size; ++step) {
    gradients_and_directions(constraints, t, at, p, C, D);
    const Eigen::FullPivLU<Matrix> CD(C * D);
    if (!CD.isInvertible()) return false;
    const Vector before = at;
    at -= D * CD.solve(values);
    const double now = evaluate();
    if (!(now < off)) {  // rounding
      at = before;
      break;
    }
    off = now;
  }
  constexpr double reached = 1e-12;
  if (!(off <= reached * size) || (at - x).lpNorm<Eigen::Infinity>() > farthest * size) return false;
  x = at;
  return true;
}

std::optional<std::size_t> held_by_friction(const HybridSystem& system, double t, const Vector& x, const Vector& p) {
  const std::optional<std::size_t> mode = mode_at(system, t, x, p);
  if (!mode || system.modes[*mode].constraints.empty() || holding_event(system, *mode)) return std::nullopt;
  return mode;
}

void keep_held(const HybridSystem& system, double t, const Vector& before, const Vector& p, Vector& x) {
  constexpr double any = std::numeric_limits<double>::infinity();
  if (const auto mode = held_by_friction(system, t, x, before)) settle_on_constraints(system, *mode, t, p, x, any);
}

HeldMap held_map(const HybridSystem& system, const Event& holding, double t, const Vector& x, const Vector& p, double duration) {
  HeldMap out{Matrix(x.size(), x.size()), -std::numeric_limits<double>::infinity()};
  if (loses_energy(holding, p)) {
    holding.accumulation->reset.dx(t, x, p, out.Phi);
    if (x.size() == 2) return out;  // there are no other coordinates
    out.slope = slope_at_rest(system, holding, out.Phi, t, x, p);
    Vector gradient(x.size());
    holding.guard.dx(t, x, p, gradient);
    out.Phi += out.slope * gradient.transpose();
    return out;
  }
  const bool position_and_speed = x.size() == 2 && holding.reset.rebound;
  const double D = position_and_speed ? divergence(system, holding, t, x, p) : std::numeric_limits<double>::quiet_NaN();
  out.log_det = D * duration;
  out.Phi.setConstant(std::isnan(D) ? D : 0.0);
  if (!position_and_speed) return out;
  const auto position = static_cast<Eigen::Index>(holding.reset.rebound->coordinate);
  const auto velocity = static_cast<Eigen::Index>(holding.reset.rebound->velocity);
  out.Phi(position, position) = std::exp(2.0 / 3.0 * out.log_det);
  out.Phi(velocity, velocity) = std::exp(1.0 / 3.0 * out.log_det);
  return out;
}

std::optional<Vector> permanent_rest(Propagator& propagator, const Vector& state) {
  const HybridSystem& system = propagator.system();
  const Vector& p = propagator.parameters();
  if (!is_forced(system) || !state.allFinite()) return std::nullopt;
  Transition transition;
  for (const Event& event : system.events) {
    if (!event.accumulation) continue;
    Vector rest = state;
    event.accumulation->reset.map(0.0, state, p, rest);
    if (mode_at(system, 0.0, rest, p) != event.accumulation->sticking_mode) continue;
    carry(propagator, 0.0, forcing_period(system, p), rest, {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination == Termination::time && transition.event_sequence.empty() && is_rest(transition.x1, rest))
      return rest;
  }
  return std::nullopt;
}

bool reaches_rest(Propagator& propagator, const Vector& state, const Vector& rest) {
  if (state == rest) return true;
  const HybridSystem& system = propagator.system();
  const Vector& p = propagator.parameters();
  Transition transition;
  carry(propagator, 0.0, forcing_period(system, p), state, {.sensitivity = Sensitivity::none, .keep_events = true}, transition);
  const bool held = transition.termination == Termination::time && holding_event(system, transition.mode1);
  if (held && is_rest(transition.x1, rest)) return true;
  const bool carried = transition.termination == Termination::time || transition.termination == Termination::event_limit;
  if (!carried || transition.events.size() < many_bounces) return false;
  const EventRecord &first = transition.events.front(), &last = transition.events.back();
  const Event& event = system.events[first.event];
  const auto same = [&](const EventRecord& one) { return one.event == first.event && one.kind == EventKind::impact; };
  if (!event.accumulation || !std::all_of(transition.events.begin(), transition.events.end(), same)) return false;
  Vector f(state.size());
  const auto log_action = [&](const EventRecord& bounce) {
    propagator.field(event.from, bounce.t, rest, f);
    return 3.0 * std::log(bounce.normal_speed) - std::log(std::abs(f[f.size() - 1]));
  };
  const double lost = event.log_volume_change ? 1.5 * event.log_volume_change(p) : 0.0;  // 3 ln k_r
  const double expected =
      lost * static_cast<double>(transition.events.size() - 1) + divergence(system, event, 0.0, rest, p) * (last.t - first.t);
  const double found = log_action(last) - log_action(first);
  return expected < 0.0 && std::abs(found - expected) < decrease_tolerance * std::abs(expected);
}

Bounces bounces_to_rest(Propagator& propagator, const Vector& rest) {
  const HybridSystem& system = propagator.system();
  const Event* holding = holding_event(system, initial_mode(system, 0.0, rest, propagator.parameters()));
  if (!holding || !holding->guard.level || rest.size() != 2) return {};
  constexpr int samples = 64;
  const double T = forcing_period(system, propagator.parameters()), sign = holding->guard.level->sign;
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  Vector f(2);
  for (int k = 0; k < samples; ++k) {
    propagator.field(holding->from, T * k / samples, rest, f);
    least = std::min(least, std::abs(f[1]));
    most = std::max(most, std::abs(f[1]));
  }
  constexpr double smallest = 1e-6;  // relative to the first speed
  const double first = least * T / (4.0 * static_cast<double>(many_bounces));
  for (double speed = first; speed > smallest * first; speed *= 0.5) {
    const double height = 0.5 * speed * speed / most;
    const auto small_enough = [&](double times) {
      const double y = times * times * height, v = times * speed;
      const Vector high{{rest[0] - sign * y, 0.0}}, fast{{rest[0], -sign * v}};
      const Vector back{{rest[0] - sign * 0.5 * y, sign * 0.5 * v}};
      return reaches_rest(propagator, high, rest) && reaches_rest(propagator, fast, rest) && reaches_rest(propagator, back, rest);
    };
    if (small_enough(1.0) && small_enough(0.5)) return {height, speed};
  }
  return {};
}

}  // namespace graze
