// SPDX-License-Identifier: GPL-3.0-or-later
#include <graze/floquet/shooting.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace graze {

namespace {

const TransitionOptions with_tangent{.sensitivity = Sensitivity::state};

double relative(const Vector& residual, const Vector& u) {
  return residual.lpNorm<Eigen::Infinity>() / (1.0 + u.lpNorm<Eigen::Infinity>());
}

/// Newton with the step halved until the residual falls; goes on below `tolerance` as long as it still gains.
NewtonReport newton(ShootingEquations& equations, Vector& u, const ShootingOptions& options) {
  NewtonReport report;
  if (!equations.evaluate(u, with_tangent)) {
    report.status = NewtonStatus::evaluation_failed;
    return report;
  }
  Vector residual, trial_residual;
  Matrix jacobian;
  equations.residual(u, residual);
  report.residual_history.push_back(relative(residual, u));
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    equations.jacobian(jacobian);
    Vector step = jacobian.partialPivLu().solve(-residual);
    if (!step.allFinite()) {
      report.status = NewtonStatus::singular;
      return report;
    }
    // A step far beyond the size of the motion comes from a nearly singular Jacobian and leads nowhere; its direction is kept.
    const double longest = options.max_step * (1.0 + u.lpNorm<Eigen::Infinity>()), length = step.lpNorm<Eigen::Infinity>();
    if (length > longest) step *= longest / length;
    const double before = relative(residual, u);
    bool reduced = false;
    double factor = 1.0;
    for (int halving = 0; halving <= options.max_halvings; ++halving, factor *= 0.5) {
      const Vector trial = u + factor * step;
      if (!equations.evaluate(trial, with_tangent)) continue;
      equations.residual(trial, trial_residual);
      const double after = relative(trial_residual, trial);
      if (!(after < before)) {
        if (before <= options.acceptance) break;  // at rounding level: nothing to be gained by halving
        continue;
      }
      u = trial;
      residual = trial_residual;
      reduced = true;
      break;
    }
    report.residual_history.push_back(relative(residual, u));
    const double now = report.residual();
    if (!reduced || (now <= options.tolerance && now > 0.5 * before)) {
      report.status = now <= options.acceptance ? NewtonStatus::converged : NewtonStatus::stalled;
      break;
    }
    if (now == 0.0) {
      report.status = NewtonStatus::converged;
      break;
    }
    report.status = now <= options.acceptance ? NewtonStatus::converged : NewtonStatus::iteration_limit;
  }
  // What was evaluated last need not be u itself.
  if (!equations.evaluate(u, with_tangent)) report.status = NewtonStatus::evaluation_failed;
  return report;
}

/// The guess as nodes: as given if their number fits, else carried on from the first.
Vector nodes_from(ShootingEquations& equations, const std::vector<Vector>& guess, double duration) {
  const int n = equations.states(), count = equations.nodes();
  Vector u(equations.unknowns());
  if (equations.autonomous()) u[n * count] = duration;
  if (static_cast<int>(guess.size()) == count) {
    for (int j = 0; j < count; ++j) u.segment(j * n, n) = guess[static_cast<std::size_t>(j)];
    return u;
  }
  Vector x = guess.front();
  Transition transition;
  for (int j = 0; j < count; ++j) {
    u.segment(j * n, n) = x;
    const double start = equations.node_time(u, j), length = equations.duration(u) / count;
    carry(equations.propagator(), start, start + length, x, {.sensitivity = Sensitivity::none}, transition);
    if (transition.termination == Termination::time) x = transition.x1;
  }
  return u;
}

/// Free re-simulation over the whole orbit: the same events in the same order.
Admissibility resimulate(ShootingEquations& equations, const Vector& u, const Signature& signature, double growth) {
  Transition whole;
  carry(equations.propagator(), 0.0, equations.duration(u), equations.node(u, 0), {.sensitivity = Sensitivity::none}, whole);
  if (whole.termination == Termination::time && whole.event_sequence == signature.events) return Admissibility::admissible;
  // An orbit so unstable that rounding grows to the size of the motion cannot be run through in one piece; its stretches, each of
  // them a free run, have shown the same already.
  const bool beyond_reach = growth * 1e-15 > 1e-6;
  return beyond_reach ? Admissibility::admissible : Admissibility::inadmissible;
}

}  // namespace

PeriodicOrbit describe_orbit(ShootingEquations& equations, const Vector& u, NewtonReport report) {
  PeriodicOrbit orbit;
  orbit.parameters = equations.parameters();
  orbit.period = equations.period();
  orbit.duration = equations.duration(u);
  orbit.newton = std::move(report);
  for (int j = 0; j < equations.nodes(); ++j) orbit.nodes.push_back(equations.node(u, j));
  orbit.state = orbit.nodes.front();
  const bool evaluated = equations.evaluate(u, {.sensitivity = Sensitivity::state, .keep_factors = true, .keep_events = true});
  if (!evaluated) {
    if (orbit.newton.converged()) orbit.newton.status = NewtonStatus::evaluation_failed;
    return orbit;
  }
  Vector residual;
  equations.residual(u, residual);
  orbit.checks.residual = relative(residual, u);
  orbit.signature.mode = equations.stretch(0).mode0;
  double log_det = 0.0, liouville = 0.0;
  for (int j = 0; j < equations.nodes(); ++j) {
    const Transition& stretch = equations.stretch(j);
    const double offset = orbit.duration * j / equations.nodes() - equations.node_time(u, j);
    for (EventRecord event : stretch.events) {
      event.t += offset;
      orbit.events.push_back(std::move(event));
    }
    orbit.signature.events.insert(orbit.signature.events.end(), stretch.event_sequence.begin(), stretch.event_sequence.end());
    orbit.monodromy.factors.insert(orbit.monodromy.factors.end(), stretch.factors.begin(), stretch.factors.end());
    log_det += stretch.log_det;
    liouville += stretch.liouville;
  }
  orbit.impacts = impacts(equations.system(), orbit.signature);
  if (equations.autonomous()) {
    orbit.monodromy.section = Section::autonomous;
    orbit.monodromy.trivial_direction.resize(equations.states());
    equations.propagator().field(orbit.signature.mode, 0.0, orbit.state, orbit.monodromy.trivial_direction);
  }
  orbit.multipliers = multipliers(orbit.monodromy, orbit.duration);
  if (std::isfinite(log_det) && std::isfinite(liouville)) orbit.checks.liouville = std::abs(log_det - liouville);
  orbit.admissible = resimulate(equations, u, orbit.signature, orbit.monodromy.product().cwiseAbs().maxCoeff());
  return orbit;
}

PeriodicOrbit shoot(const HybridSystem& system, const Vector& p, const std::vector<Vector>& guess, int period,
                    const ShootingOptions& options, double duration_guess) {
  if (guess.empty()) throw std::invalid_argument("shooting needs a state to start from");
  ShootingEquations equations(system, p, period, options.nodes, std::nullopt, options.flow);
  if (equations.autonomous() && !(duration_guess > 0.0))
    throw std::invalid_argument(fmt::format("the duration guess is {}; an autonomous orbit needs one > 0", duration_guess));
  for (const Vector& x : guess) initial_mode(system, 0.0, x, p);
  Vector u = nodes_from(equations, guess, duration_guess);
  if (equations.autonomous()) equations.set_phase_reference(guess.front());
  NewtonReport report = newton(equations, u, options);
  PeriodicOrbit orbit = describe_orbit(equations, u, std::move(report));
  if (orbit.converged() && options.reduce_period && period > 1) {
    const std::vector<Vector> states = stroboscopic_states(system, orbit, options.flow);
    for (int divisor = 1; divisor <= period / 2; ++divisor) {
      if (period % divisor != 0) continue;
      const double scale = 1.0 + orbit.state.lpNorm<Eigen::Infinity>();
      const Vector& later = states[static_cast<std::size_t>(divisor)];
      // Near a period doubling the doubled orbit passes its own start closely without closing there: only Newton decides.
      if ((later - orbit.state).lpNorm<Eigen::Infinity>() > 1e-5 * scale) continue;
      ShootingOptions shorter = options;
      if (options.nodes % divisor != 0) shorter.nodes = 0;
      PeriodicOrbit candidate = shoot(system, p, Vector(0.5 * (later + orbit.state)), divisor, shorter);
      if (candidate.converged() && (candidate.state - orbit.state).lpNorm<Eigen::Infinity>() < 1e-10 * scale) return candidate;
    }
  }
  if (orbit.converged() && options.finite_differences)
    orbit.checks.finite_difference = finite_difference_check(system, orbit, options.flow);
  return orbit;
}

std::vector<Vector> stroboscopic_states(const HybridSystem& system, const PeriodicOrbit& orbit, const FlowOptions& options) {
  std::vector<Vector> states;
  const auto nodes = static_cast<int>(orbit.nodes.size());
  if (nodes % orbit.period == 0) {
    for (int k = 0; k < orbit.period; ++k) states.push_back(orbit.nodes[static_cast<std::size_t>(k * (nodes / orbit.period))]);
    return states;
  }
  Propagator propagator(system, orbit.parameters, {}, options);
  const double T = forcing_period(system, orbit.parameters);
  Transition transition;
  states.push_back(orbit.state);
  while (static_cast<int>(states.size()) < orbit.period) {
    carry(propagator, 0.0, T, states.back(), {.sensitivity = Sensitivity::none}, transition);
    states.push_back(transition.x1);
  }
  return states;
}

bool same_orbit(const HybridSystem& system, const PeriodicOrbit& a, const PeriodicOrbit& b, double tolerance) {
  if (a.period != b.period) return false;
  const double scale = 1.0 + a.state.lpNorm<Eigen::Infinity>();
  const std::vector<Vector> states = stroboscopic_states(system, b);
  return std::any_of(states.begin(), states.end(),
                     [&](const Vector& x) { return (x - a.state).lpNorm<Eigen::Infinity>() < tolerance * scale; });
}

}  // namespace graze
